// Who has control of the bench: taken under a name, shown to everybody, given back.
import { defineStore } from 'pinia'
import { computed, ref } from 'vue'
import { api, command, read } from '../api/client'
import { serverNow } from '../api/clock'
import { keepLease, leaseOfTab } from '../api/lease'
import { useLive } from '../api/push/live'
import { Refused } from '../api/refused'
import { usePreferences } from './preferences'

const RENEW_BELOW_S = 240

export const useControl = defineStore('control', () => {
  const live = useLive()
  const preferences = usePreferences()
  const kept = ref(leaseOfTab())
  const state = computed(() => live.bench.control)
  const mine = computed(
    () => state.value.holder !== null && kept.value !== null && state.value.since === kept.value.since,
  )
  /** Seconds until it is free by itself, if nothing is done. */
  const left_s = computed(() => {
    if (state.value.ends_at === null) return 0
    return Math.max(0, (Date.parse(state.value.ends_at) - serverNow(live.now)) / 1000)
  })

  /** Take it; from somebody else only with a reason. */
  async function take(name: string, reason = ''): Promise<void> {
    const body = { name: name.trim(), reason }
    const told = await command(() => api.POST('/api/v1/control/take', { body })).catch(async (failure: unknown) => {
      if (failure instanceof Refused && failure.status === 423) live.bench.control = await read(api.GET('/api/v1/control'))
      throw failure
    })
    keep({ lease: told.lease, since: told.control.since })
    live.bench.control = told.control
    preferences.name = body.name
  }

  /** Somebody who works at the page keeps control; the lease stays the same. */
  async function renew(): Promise<void> {
    if (!mine.value || !live.live || left_s.value > RENEW_BELOW_S) return
    await take(state.value.holder ?? preferences.name).catch(() => undefined) // it ends by itself, as shown
  }

  async function release(): Promise<void> {
    live.bench.control = await command(() => api.POST('/api/v1/control/release'))
    keep(null)
  }

  /** Ask whoever has it; gives back what the server says. */
  async function ask(name: string): Promise<string> {
    return (await read(api.POST('/api/v1/control/ask', { body: { name } }))).text
  }

  function keep(lease: { lease: string; since: string | null } | null): void {
    kept.value = lease
    keepLease(lease)
  }

  return { state, mine, left_s, take, renew, release, ask }
})
