// STOP ALL: sent at once by two routes; a device that did not confirm is always reported.
import { defineStore } from 'pinia'
import { computed, ref } from 'vue'
import { newKey } from '../api/client'
import { serverNow } from '../api/clock'
import { useConnection } from '../api/updates/connection'
import { askSocket } from '../api/updates/socket'
import type { Fault, Stopped } from '../api/types'
import { usePreferences } from './preferences'

/** After this long without an answer it is an alarm; a later answer is still shown. */
export const ALARM_MS = 1_000
const PATIENCE_MS = 5_000
const DONE_MS = 10_000

export type StopState = 'calm' | 'stopping' | 'confirmed' | 'alarm'

export const useStop = defineStore('stop', () => {
  const connection = useConnection()
  const preferences = usePreferences()
  const state = ref<StopState>('calm')
  const answer = ref<Stopped | null>(null)
  const failure = ref('')
  let latest = 0

  /** No question, no control, no sign-in; each press is one stop, and none is ever queued. */
  async function stopAll(): Promise<void> {
    const mine = ++latest
    state.value = 'stopping'
    answer.value = null
    failure.value = ''
    const alarm = setTimeout(() => {
      if (mine === latest && state.value === 'stopping') state.value = 'alarm'
    }, ALARM_MS)
    try {
      const press = newKey()
      const told = await Promise.any([byPost(press), bySocket(press)])
      if (mine === latest) took(told)
    } catch {
      if (mine !== latest) return
      failure.value = 'the server did not answer'
      state.value = 'alarm'
    } finally {
      clearTimeout(alarm)
    }
  }

  /** Bypasses everything that could delay it; it is sent even while the page is closing. */
  async function byPost(press: string): Promise<Stopped> {
    const response = await fetch('/api/v1/stop', {
      method: 'POST', keepalive: true,
      headers: { 'Idempotency-Key': press, 'X-Deadline': String(until()), 'X-Name': encodeURIComponent(preferences.name) },
      signal: AbortSignal.timeout(PATIENCE_MS),
    })
    if (!response.ok) throw new Error(`the server answered ${response.status}`)
    return (await response.json()) as Stopped
  }

  async function bySocket(press: string): Promise<Stopped> {
    const socket = connection.line()
    if (socket === null) throw new Error('no connection')
    const told = await askSocket<Stopped | Fault>(
      socket, 'stop', { press, until_ms: until(), name: preferences.name }, PATIENCE_MS,
    )
    if ('devices' in told) return told
    throw new Error(told.message)
  }

  /** A stop stuck in a stalled connection for longer must not stop what was started since. */
  function until(): number {
    return Math.round(serverNow() + PATIENCE_MS)
  }

  function took(told: Stopped): void {
    answer.value = told
    const runs_told = told.runs.every((run) => run.told)
    state.value = told.all_confirmed && runs_told ? 'confirmed' : 'alarm'
    if (state.value === 'confirmed') {
      const mine = latest
      setTimeout(() => mine === latest && calm(), DONE_MS)
    }
  }

  function calm(): void {
    state.value = 'calm'
  }

  /** Devices that have not confirmed: from the answer, or all of them if there is none. */
  const silent = computed(() =>
    answer.value === null
      ? Object.keys(connection.bench.devices)
      : answer.value.devices.filter((one) => !one.confirmed).map((one) => one.device),
  )

  return { state, answer, failure, silent, stopAll, calm }
})
