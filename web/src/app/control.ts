// Who has control of the bench: taken under a name, shown to everyone, released.
import { defineStore } from 'pinia'
import { computed, ref } from 'vue'
import { api, command, read } from '../api/client'
import { serverNow } from '../api/clock'
import { keepLease, leaseOfTab } from '../api/lease'
import { useConnection } from '../api/updates/connection'
import { Refused } from '../api/refused'
import { usePreferences } from './preferences'

const RENEW_BELOW_S = 240

export const useControl = defineStore('control', () => {
  const connection = useConnection()
  const preferences = usePreferences()
  const kept = ref(leaseOfTab())
  const state = computed(() => connection.bench.control)
  const mine = computed(
    () => state.value.holder !== null && kept.value !== null && state.value.since === kept.value.since,
  )
  /** Seconds until it is released automatically. */
  const left_s = computed(() => {
    if (state.value.ends_at === null) return 0
    return Math.max(0, (Date.parse(state.value.ends_at) - serverNow(connection.now)) / 1000)
  })

  /** Take it; from someone else only with a reason. */
  async function take(name: string, reason = ''): Promise<void> {
    const body = { name: name.trim(), reason }
    const told = await command(() => api.POST('/api/v1/control/take', { body })).catch(async (failure: unknown) => {
      if (failure instanceof Refused && failure.status === 423) connection.bench.control = await read(api.GET('/api/v1/control'))
      throw failure
    })
    keep({ lease: told.lease, since: told.control.since })
    connection.bench.control = told.control
    preferences.name = body.name
  }

  /** Someone who works at the page keeps control; the lease stays the same. */
  async function renew(): Promise<void> {
    if (!mine.value || !connection.live || left_s.value > RENEW_BELOW_S) return
    await take(state.value.holder ?? preferences.name).catch(() => undefined) // it expires, as shown
  }

  async function release(): Promise<void> {
    connection.bench.control = await command(() => api.POST('/api/v1/control/release'))
    keep(null)
  }

  /** Ask its holder; returns the server's answer. */
  async function ask(name: string): Promise<string> {
    return (await read(api.POST('/api/v1/control/ask', { body: { name } }))).text
  }

  function keep(lease: { lease: string; since: string | null } | null): void {
    kept.value = lease
    keepLease(lease)
  }

  return { state, mine, left_s, take, renew, release, ask }
})
