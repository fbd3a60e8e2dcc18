// What this browser stores for a device with axes: saved positions and the user's own zero.
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

/** Both by device; changes are saved at once. */
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
