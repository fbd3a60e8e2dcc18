// The protocols that this person has starred.
import { ref, watch } from 'vue'

const KEY = 'labrun.stars'

export function useStars() {
  const stars = ref(new Set<string>(kept()))
  watch(stars, (now) => localStorage.setItem(KEY, JSON.stringify([...now])))

  function toggle(name: string): void {
    const now = new Set(stars.value)
    if (!now.delete(name)) now.add(name)
    stars.value = now
  }

  return { stars, toggle }
}

function kept(): string[] {
  try {
    const told: unknown = JSON.parse(localStorage.getItem(KEY) ?? '[]')
    return Array.isArray(told) ? told.map(String) : []
  } catch {
    return []
  }
}
