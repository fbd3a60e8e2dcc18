// Keys that work on every page; single letters can be switched off (WCAG 2.1.4).
import { onScopeDispose } from 'vue'
import { useRouter } from 'vue-router'
import { usePreferences } from './preferences'

export const PLACES: Record<string, string> = {
  d: 'devices', p: 'protocols', r: 'runs', e: 'results', s: 'settings',
}
const WITHIN_MS = 1_500
const WRITING = 'input, textarea, select, [contenteditable="true"], [contenteditable=""], [role="textbox"]'

/** `g` and a letter goes to a place, `/` finds, `?` calls `help`. */
export function useShortcuts(help: () => void): void {
  const preferences = usePreferences()
  const router = useRouter()
  let going = -Infinity
  const pressed = (event: KeyboardEvent): void => {
    if (!preferences.singleKeys || event.ctrlKey || event.metaKey || event.altKey) return
    if (event.defaultPrevented || isWriting(event.target)) return
    const place = PLACES[event.key]
    if (event.timeStamp - going <= WITHIN_MS && place !== undefined) {
      event.preventDefault()
      void router.push({ name: place })
    } else if (event.key === '?') help()
    else if (event.key === '/') find(event)
    going = event.key === 'g' ? event.timeStamp : -Infinity
  }
  window.addEventListener('keydown', pressed)
  onScopeDispose(() => window.removeEventListener('keydown', pressed))
}

function isWriting(target: EventTarget | null): boolean {
  return target instanceof Element && target.closest(WRITING) !== null
}

function find(event: KeyboardEvent): void {
  const field = document.querySelector<HTMLElement>('main input[type="search"]')
  if (field === null) return
  event.preventDefault()
  field.focus()
}
