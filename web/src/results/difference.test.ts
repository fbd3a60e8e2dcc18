import { expect, test } from 'vitest'
import { difference, drawDifference, largest } from './difference'

const SMALL = { width: 2, height: 2, x: [0, 1], y: [0, 1] }
const WIDE = { width: 3, height: 1, x: [-1, 0, 1.00001], y: [1] }

test('values are subtracted place by place, and what only one has is a hole', () => {
  const found = difference(SMALL, Float32Array.of(1, 2, 3, 4), WIDE, Float32Array.of(9, 5, 1))

  expect([...found]).toEqual([NaN, NaN, 2, -3])
  expect(largest(found)).toBe(3)
})

test('more is orange, less is blue, alike is white, a hole transparent, the highest y on top', () => {
  const { data } = drawDifference(Float32Array.of(NaN, 0, 3, -3), 2, 2, 3)

  expect([...data]).toEqual([200, 90, 0, 255, 0, 80, 190, 255, 0, 0, 0, 0, 255, 255, 255, 255])
})
