// The cursor on a map, and the point that it has come to rest on: each follows the other, but never back.
import { ref, watch, type Ref } from 'vue'

const REST_MS = 200

/** `point` may take its new value late (the page's address has it): until then, and then too, the cursor stays where a person has put it. */
export function useCursor(keys: Ref<readonly (string | null)[]>, point: Ref<string>): Ref<number> {
  const cursor = ref(0)
  let sought = ''
  let timer: ReturnType<typeof setTimeout> | undefined

  function put(key: string, all: readonly (string | null)[]): void {
    const cell = all.indexOf(key)
    if (cell >= 0) cursor.value = cell
  }
  watch(keys, (all, before) => put(before?.[cursor.value] ?? point.value, all), { immediate: true })
  watch(point, (key) => {
    if (key === sought) return
    sought = key
    put(key, keys.value)
  })
  watch(cursor, (cell) => {
    clearTimeout(timer)
    const key = keys.value[cell]
    if (key == null || key === sought) return
    timer = setTimeout(() => {
      sought = key
      point.value = key
    }, REST_MS)
  })
  return cursor
}
