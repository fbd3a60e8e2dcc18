// Which dialogs are open. What is behind one cannot be reached meanwhile, but the frame's header
// can: STOP ALL is in it. Esc closes the uppermost, wherever the focus is.
import { computed, shallowRef } from 'vue'

const open = shallowRef<(() => void)[]>([])

/** How far the clicks of a double click are apart at most. */
const DOUBLE_MS = 700
let changed_at = -Infinity

export const dialogOpen = computed(() => open.value.length > 0)

export function dialogOpened(close: () => void): void {
  if (!dialogOpen.value) window.addEventListener('keydown', pressed)
  open.value = [...open.value, close]
  changed_at = performance.now()
}

export function dialogClosed(close: () => void): void {
  open.value = open.value.filter((one) => one !== close)
  changed_at = performance.now()
  if (!dialogOpen.value) window.removeEventListener('keydown', pressed)
}

function pressed(event: KeyboardEvent): void {
  if (event.key === 'Escape') open.value.at(-1)?.()
}

/** The second click of a double click was meant for what opened or closed a dialog, and not for what is in its place now. */
function second(event: MouseEvent): void {
  if (event.detail < 2 || performance.now() - changed_at > DOUBLE_MS) return
  event.preventDefault()
  event.stopPropagation()
}
for (const kind of ['mousedown', 'click'] as const) window.addEventListener(kind, second, true)
