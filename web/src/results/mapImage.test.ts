import { expect, test } from 'vitest'
import { drawMap, drawOverlay } from './mapImage'

const scale = { low: 0, high: 1, log: false }

test('the lowest y is at the bottom, and a hole is transparent', () => {
  const { data } = drawMap(new Float32Array([0, 1, NaN, 1]), 2, 2, scale, 'greys')

  expect([...data.slice(0, 4)]).toEqual([0, 0, 0, 0])
  expect([...data.slice(4, 8)]).toEqual([0, 0, 0, 255])
  expect([...data.slice(8, 12)]).toEqual([255, 255, 255, 255])
})

test('an overlay is orange, blue, white or black', () => {
  const first = new Float32Array([1, 0, 1, 0])
  const second = new Float32Array([0, 1, 1, 0])
  const { data } = drawOverlay(first, second, 4, 1, [scale, scale])

  expect([...data]).toEqual([255, 150, 30, 255, 0, 105, 225, 255, 255, 255, 255, 255, 0, 0, 0, 255])
})

test('a map with too few values is refused', () => {
  expect(() => drawMap(new Float32Array(3), 2, 2, scale, 'viridis')).toThrow('3 values for a map of 2 × 2')
})
