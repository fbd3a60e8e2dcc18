// What this browser remembers about its user.
import { defineStore } from 'pinia'
import { reactive, toRefs, watch } from 'vue'

const KEY = 'labrun.preferences'

export interface Preferences {
  name: string
  theme: 'system' | 'light' | 'dark'
  lab: boolean
  singleKeys: boolean
  notifications: boolean
  welcomed: boolean
}

const FIRST: Preferences = {
  name: '', theme: 'system', lab: false, singleKeys: true, notifications: false, welcomed: false,
}

function kept(): Preferences {
  try {
    return { ...FIRST, ...(JSON.parse(localStorage.getItem(KEY) ?? '{}') as Partial<Preferences>) }
  } catch {
    return { ...FIRST }
  }
}

/** The preferences; every change is saved at once. */
export const usePreferences = defineStore('preferences', () => {
  const preferences = reactive(kept())
  watch(preferences, (now) => localStorage.setItem(KEY, JSON.stringify(now)))
  return toRefs(preferences)
})
