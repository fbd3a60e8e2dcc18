// What this browser keeps of a device with axes: places with names, and a zero of one's own.
import { ref, type Ref, watch } from 'vue'
import type { Place } from './axes'

export interface NamedPlace {
  name: string
  place: Place
}

interface Kept {
  places: NamedPlace[]
  zero: Place
}

/** Both by device; changes are kept at once. */
export function useKept(device: string): Ref<Kept> {
  const key = `labrun.places.${device}`
  const kept = ref<Kept>(read(key))
  watch(kept, (now) => localStorage.setItem(key, JSON.stringify(now)), { deep: true })
  return kept
}

function read(key: string): Kept {
  try {
    return { places: [], zero: {}, ...(JSON.parse(localStorage.getItem(key) ?? '{}') as Partial<Kept>) }
  } catch {
    return { places: [], zero: {} }
  }
}
