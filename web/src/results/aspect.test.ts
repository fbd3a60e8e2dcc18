import { expect, test } from 'vitest'
import { cellAspect } from './aspect'

test('cells are as tall as their spacing', () => {
  expect(cellAspect([0, 1, 2], [0, 2, 4])).toBe(2)
  expect(cellAspect([0, 1], [0, 100])).toBe(8)
  expect(cellAspect([5], [0, 1])).toBe(1)
})
