// How many dialogs are open. What is behind one cannot be reached meanwhile, but the frame's header
// can: STOP ALL is in it.
import { computed, ref } from 'vue'

const open = ref(0)

export const dialogOpen = computed(() => open.value > 0)

export function dialogOpened(): void {
  open.value += 1
}

export function dialogClosed(): void {
  open.value -= 1
}
