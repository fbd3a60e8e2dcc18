import { expect, test } from 'vitest'
import { scaleFor, shareOf, shortNumber, ticks } from './scale'

const range = { minimum: 0, maximum: 200, p2: 10, p98: 110 }

test('each scale has its own ends', () => {
  expect(scaleFor(range, 'min–max', false)).toEqual({ low: 0, high: 200, log: false })
  expect(scaleFor(range, 'p2–p98', false)).toEqual({ low: 10, high: 110, log: false })
  expect(scaleFor(range, '0–1', false)).toEqual({ low: 0, high: 1, log: false })
})

test('values outside are drawn as the ends, and a hole stays a hole', () => {
  const scale = scaleFor(range, 'p2–p98', false)

  expect(shareOf(scale, 60)).toBeCloseTo(0.5)
  expect(shareOf(scale, 1e6)).toBe(1)
  expect(shareOf(scale, -1)).toBe(0)
  expect(shareOf(scale, NaN)).toBeNaN()
})

test('a logarithmic scale begins at the smallest value above zero', () => {
  const scale = scaleFor(range, 'min–max', true, new Float32Array([0, NaN, 2, 200]))

  expect(scale.low).toBe(2)
  expect(shareOf(scale, 20)).toBeCloseTo(0.5)
  expect(shareOf(scale, 0)).toBe(0)
})

test('a map of one value, or of none, still has a scale', () => {
  const flat = { minimum: 5, maximum: 5, p2: 5, p98: 5 }
  const none = { minimum: null, maximum: null, p2: null, p98: null }
  for (const one of [flat, none])
    for (const log of [false, true]) {
      const scale = scaleFor(one, 'min–max', log)

      expect(scale.high).toBeGreaterThan(scale.low)
      expect(ticks(scale).length).toBeGreaterThan(0)
    }
})

test('marks are round numbers within the scale', () => {
  expect(ticks({ low: 0, high: 200, log: false }).map((t) => t.text)).toEqual(['0', '50', '100', '150', '200'])
  expect(ticks({ low: 1, high: 20000, log: true }).map((t) => t.text)).toEqual(['1', '10', '100', '1000', '10k'])
})

test('numbers are short', () => {
  expect([0, 0.1234, 1234.5, 32816, 4.2e6, 1e-7, -12345].map(shortNumber)).toEqual([
    '0', '0.123', '1230', '32.8k', '4.2M', '1.0e-7', '-12.3k',
  ])
})
