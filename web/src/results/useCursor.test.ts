import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest'
import { computed, nextTick, ref, shallowRef } from 'vue'
import { useCursor } from './useCursor'

/** A point that takes its value only when the address has changed, as on a slow computer. */
function slowPoint(first: string, ms: number) {
  const now = ref(first)
  return computed({ get: () => now.value, set: (key) => void setTimeout(() => (now.value = key), ms) })
}

const KEYS = ['a', 'b', null, 'd', 'e']
beforeEach(() => void vi.useFakeTimers())
afterEach(() => void vi.useRealTimers())

describe('cursor', () => {
  it('stays where it was put last, though the point of the place before arrives late', async () => {
    const point = slowPoint('a', 500)
    const cursor = useCursor(shallowRef(KEYS), point)
    cursor.value = 3
    await nextTick()
    await vi.advanceTimersByTimeAsync(650) // it rested on d, whose spectrum is asked for
    cursor.value = 4
    await nextTick()
    await vi.advanceTimersByTimeAsync(2000)

    expect([cursor.value, point.value]).toEqual([4, 'e'])
  })

  it('comes back to the first point, though another is on its way', async () => {
    const point = slowPoint('a', 500)
    const cursor = useCursor(shallowRef(KEYS), point)
    for (const cell of [1, 0]) {
      cursor.value = cell
      await nextTick()
      await vi.advanceTimersByTimeAsync(250)
    }
    await vi.advanceTimersByTimeAsync(2000)

    expect([cursor.value, point.value]).toEqual([0, 'a'])
  })

  it('goes to a point that was opened elsewhere, and stays on its own when maps arrive anew', async () => {
    const keys = shallowRef<readonly (string | null)[]>([])
    const point = slowPoint('b', 0)
    const cursor = useCursor(keys, point)
    keys.value = KEYS
    await nextTick()

    expect(cursor.value).toBe(1)

    point.value = 'e'
    await vi.advanceTimersByTimeAsync(1)

    expect(cursor.value).toBe(4)

    cursor.value = 3
    await nextTick()
    keys.value = ['new', ...KEYS]
    await vi.advanceTimersByTimeAsync(1000)

    expect([cursor.value, point.value]).toEqual([4, 'd'])
  })
})
