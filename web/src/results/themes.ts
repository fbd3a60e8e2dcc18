// The page's colours for drawing on a canvas, and their changes.
import { onScopeDispose, shallowRef, type Ref } from 'vue'

export interface Theme {
  text: string
  muted: string
  line: string
  bg: string
  panel: string
  accent: string
  ok: string
  warn: string
  fail: string
  paused: string
}

const NAMES: readonly (keyof Theme)[] = ['text', 'muted', 'line', 'bg', 'panel', 'accent', 'ok', 'warn', 'fail', 'paused']

function now(): Theme {
  const style = getComputedStyle(document.documentElement)
  return Object.fromEntries(NAMES.map((name) => [name, style.getPropertyValue(`--${name}`).trim() || '#888888'])) as unknown as Theme
}

/** The colours as they are now; updated when the theme changes. */
export function useTheme(): Ref<Theme> {
  const theme = shallowRef(now())
  const observer = new MutationObserver(() => (theme.value = now()))
  observer.observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme', 'data-lab'] })
  onScopeDispose(() => observer.disconnect())
  return theme
}
