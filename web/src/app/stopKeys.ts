// Esc Esc within 0.6 s stops everything, from anywhere on the page.
import { onScopeDispose } from 'vue'

export const WITHIN_MS = 600

/** Calls `stop` on the second of two presses; holding the key down is one press. */
export function useStopKeys(stop: () => void): void {
  let last = -Infinity
  const pressed = (event: KeyboardEvent): void => {
    if (event.key !== 'Escape') {
      last = -Infinity
      return
    }
    if (event.repeat) return
    if (event.timeStamp - last <= WITHIN_MS) {
      last = -Infinity
      stop()
    } else last = event.timeStamp
  }
  // In the capture phase, before any element can stop it.
  window.addEventListener('keydown', pressed, { capture: true })
  onScopeDispose(() => window.removeEventListener('keydown', pressed, { capture: true }))
}
