// Which dialogs are open. What is behind one cannot be reached meanwhile, but the frame's header
// can: STOP ALL is in it. Esc closes the uppermost, wherever the focus is.
import { computed, shallowRef } from 'vue'

const open = shallowRef<(() => void)[]>([])

export const dialogOpen = computed(() => open.value.length > 0)

export function dialogOpened(close: () => void): void {
  if (!dialogOpen.value) window.addEventListener('keydown', pressed)
  open.value = [...open.value, close]
}

export function dialogClosed(close: () => void): void {
  open.value = open.value.filter((one) => one !== close)
  if (!dialogOpen.value) window.removeEventListener('keydown', pressed)
}

function pressed(event: KeyboardEvent): void {
  if (event.key === 'Escape') open.value.at(-1)?.()
}
