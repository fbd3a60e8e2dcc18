// The size of an element while it exists.
import { onScopeDispose, shallowRef, watch, type Ref } from 'vue'

export function useSize(element: Readonly<Ref<HTMLElement | null>>): Ref<{ width: number; height: number }> {
  const size = shallowRef({ width: 0, height: 0 })
  const observer = new ResizeObserver(([entry]) => {
    if (!entry) return
    const { width, height } = entry.contentRect
    if (width !== size.value.width || height !== size.value.height) size.value = { width, height }
  })
  // It may appear later than the component, and go before it.
  watch(element, (now) => {
    observer.disconnect()
    if (now) observer.observe(now)
  }, { immediate: true })
  onScopeDispose(() => observer.disconnect())
  return size
}
