// The size of an element while it exists.
import { onBeforeUnmount, onMounted, shallowRef, type Ref } from 'vue'

export function useSize(element: Readonly<Ref<HTMLElement | null>>): Ref<{ width: number; height: number }> {
  const size = shallowRef({ width: 0, height: 0 })
  const observer = new ResizeObserver(([entry]) => {
    if (!entry) return
    const { width, height } = entry.contentRect
    if (width !== size.value.width || height !== size.value.height) size.value = { width, height }
  })
  onMounted(() => element.value && observer.observe(element.value))
  onBeforeUnmount(() => observer.disconnect())
  return size
}
