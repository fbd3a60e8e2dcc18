// The space for the editor: where it begins, and how many panes fit.
import { onBeforeUnmount, onMounted, ref, type Ref, type ShallowRef } from 'vue'

function useMedia(query: string): Ref<boolean> {
  const media = window.matchMedia(query)
  const on = ref(media.matches)
  const changed = (): void => {
    on.value = media.matches
  }
  media.addEventListener('change', changed)
  onBeforeUnmount(() => media.removeEventListener('change', changed))
  return on
}

export function useRoom(box: Readonly<ShallowRef<HTMLElement | null>>) {
  const top = ref(64)
  let watching: ResizeObserver | undefined

  function measure(): void {
    if (box.value) top.value = Math.round(box.value.getBoundingClientRect().top + window.scrollY)
  }
  onMounted(() => {
    watching = new ResizeObserver(measure)
    for (const one of [document.body, ...document.querySelectorAll('.frame > *')]) watching.observe(one)
    measure()
  })
  onBeforeUnmount(() => watching?.disconnect())
  return { top, wide: useMedia('(width >= 1200px)'), thumbs: useMedia('(width < 768px) and (pointer: coarse)') }
}
