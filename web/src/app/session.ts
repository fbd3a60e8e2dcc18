// Whether this browser is signed in, and what the server is.
import { defineStore } from 'pinia'
import { computed, ref } from 'vue'
import { api, read } from '../api/client'
import { heardTime } from '../api/clock'
import type { AllSettings, Sent, Session, Settings } from '../api/types'

const AGAIN_MS = 2_000

export const useSession = defineStore('session', () => {
  const session = ref<Session | null>(null)
  const all = ref<AllSettings | null>(null)

  const signed_in = computed(() => session.value?.signed_in ?? false)

  /** Ask until the server answers; without a token that signs in. */
  async function enter(): Promise<void> {
    while (session.value === null) {
      await look()
      if (session.value === null) await new Promise((resolve) => setTimeout(resolve, AGAIN_MS))
    }
  }

  /** Ask once whether this browser is signed in; a server that does not answer changes nothing. */
  async function look(): Promise<boolean> {
    return take(read(api.GET('/api/v1/session'))).then((told) => told.signed_in, () => false)
  }

  /** Sign in with the token that `labrun web` was started with. */
  async function signIn(token: string): Promise<void> {
    await take(read(api.POST('/api/v1/session', { body: { token } })))
  }

  async function signOut(): Promise<void> {
    await take(read(api.DELETE('/api/v1/session')))
  }

  async function loadSettings(): Promise<void> {
    all.value = await read(api.GET('/api/v1/settings'))
  }

  async function saveSettings(settings: Settings): Promise<void> {
    all.value = await read(api.PUT('/api/v1/settings', { body: settings as Sent<'Settings'> }))
  }

  async function take(asked: Promise<Session>): Promise<Session> {
    const told = await asked
    heardTime(told.server_time_ms)
    session.value = told
    return told
  }

  return { session, signed_in, all, enter, look, signIn, signOut, loadSettings, saveSettings }
})
