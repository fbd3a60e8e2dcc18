import { type EffectScope, effectScope } from 'vue'
import { afterEach, beforeEach, expect, it, vi } from 'vitest'
import { useStopKeys } from './stopKeys'

const stop = vi.fn()
let frame: EffectScope
beforeEach(() => {
  frame = effectScope()
  frame.run(() => useStopKeys(stop))
})
afterEach(() => {
  frame.stop()
  stop.mockClear()
})

function press(key: string, at: number, repeat = false): void {
  const event = new KeyboardEvent('keydown', { key, repeat })
  Object.defineProperty(event, 'timeStamp', { value: at })
  window.dispatchEvent(event)
}

it('Esc Esc within 0.6 s stops, once for each pair', () => {
  for (const at of [0, 500, 900]) press('Escape', at)

  expect(stop).toHaveBeenCalledTimes(1)

  press('Escape', 1_400)

  expect(stop).toHaveBeenCalledTimes(2)
})

it('slow presses, a held key and another key in between do not stop', () => {
  press('Escape', 10_000)
  press('Escape', 10_700)
  press('Escape', 10_800, true)
  press('a', 10_900)
  press('Escape', 11_000)

  expect(stop).not.toHaveBeenCalled()
})

it('stops listening when the frame is gone', () => {
  frame.stop()
  press('Escape', 20_000)
  press('Escape', 20_100)

  expect(stop).not.toHaveBeenCalled()
})
