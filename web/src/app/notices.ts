// Notices in a corner: problems stay until dismissed, the rest disappear.
import { defineStore } from 'pinia'
import { ref } from 'vue'
import { sentenceOf } from '../api/refused'

const GOES_MS = 8_000
const MOST = 5

export interface Shown {
  id: number
  level: 'info' | 'problem'
  text: string
  run: string | null
  device: string | null
}

export const useNotices = defineStore('notices', () => {
  const shown = ref<Shown[]>([])
  let last = 0

  function tell(text: string, more: Partial<Omit<Shown, 'id' | 'text'>> = {}): void {
    const same = shown.value.find((one) => one.text === text)
    if (same !== undefined) return
    const notice: Shown = { id: ++last, level: 'info', run: null, device: null, text, ...more }
    shown.value = [...shown.value, notice].slice(-MOST)
    if (notice.level === 'info') setTimeout(() => drop(notice.id), GOES_MS)
  }

  /** A failure of something that was clicked. */
  function tellFailure(failure: unknown): void {
    tell(sentenceOf(failure), { level: 'problem' })
  }

  function drop(id: number): void {
    shown.value = shown.value.filter((one) => one.id !== id)
  }

  return { shown, tell, tellFailure, drop }
})
