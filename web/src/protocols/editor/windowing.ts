// Only the visible rows and a few around them are drawn.
import { computed, onBeforeUnmount, onMounted, ref, type Ref, type ShallowRef } from 'vue'

const AROUND = 8

export function useWindow(box: Readonly<ShallowRef<HTMLElement | null>>, count: Ref<number>, height: number) {
  const top = ref(0)
  const tall = ref(600)
  let watching: ResizeObserver | undefined
  let frame = 0

  const first = computed(() => Math.max(0, Math.min(Math.floor(top.value / height) - AROUND, count.value - 1)))
  const last = computed(() => Math.min(count.value, Math.ceil((top.value + tall.value) / height) + AROUND))

  function scrolled(): void {
    cancelAnimationFrame(frame)
    frame = requestAnimationFrame(() => (top.value = box.value?.scrollTop ?? 0))
  }

  /** Scroll as little as needed to show a whole row. */
  function reveal(row: number): void {
    const element = box.value
    if (!element) return
    const at = row * height
    if (at < element.scrollTop) element.scrollTop = at
    else if (at + height > element.scrollTop + element.clientHeight) element.scrollTop = at + height - element.clientHeight
    top.value = element.scrollTop
  }

  onMounted(() => {
    tall.value = box.value?.clientHeight || 600
    watching = new ResizeObserver(() => (tall.value = box.value?.clientHeight || 600))
    if (box.value) watching.observe(box.value)
  })
  onBeforeUnmount(() => {
    watching?.disconnect()
    cancelAnimationFrame(frame)
  })
  return { first, last, tall, scrolled, reveal, pageRows: computed(() => Math.max(1, Math.floor(tall.value / height) - 1)) }
}
