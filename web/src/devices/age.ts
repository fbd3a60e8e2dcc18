// How old what a device last said is, by the server's clock.
import { computed, type ComputedRef } from 'vue'
import { serverNow } from '../api/clock'
import { useLive } from '../api/push/live'
import type { DeviceState } from '../api/types'

/** Older than this, a value may not be so any more. */
export const OLD_S = 3

/** Seconds since its last status; null where there never was one. */
export function useAge(device: () => DeviceState | undefined): ComputedRef<number | null> {
  const live = useLive()
  return computed(() => {
    const at = device()?.status_at
    return at == null ? null : Math.max(0, (serverNow(live.now) - Date.parse(at)) / 1000)
  })
}
