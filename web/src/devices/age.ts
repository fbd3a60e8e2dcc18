// The age of a device's last status, by the server's clock.
import { computed, type ComputedRef } from 'vue'
import { serverNow } from '../api/clock'
import { useConnection } from '../api/updates/connection'
import type { DeviceState } from '../api/types'

/** Older than this, a value may be out of date. */
export const OLD_S = 3

/** Seconds since its last status; null if there never was one. */
export function useAge(device: () => DeviceState | undefined): ComputedRef<number | null> {
  const connection = useConnection()
  return computed(() => {
    const at = device()?.status_at
    return at == null ? null : Math.max(0, (serverNow(connection.now) - Date.parse(at)) / 1000)
  })
}
