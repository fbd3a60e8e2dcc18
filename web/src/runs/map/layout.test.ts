import { expect, test } from 'vitest'
import { PointTable } from '../points'
import { layoutOf } from './layout'

function table(places: [number, number][]): PointTable {
  const made = new PointTable('main/scan')
  made.load({
    total: places.length, index: places.map((_, i) => i), key: places.map(() => null),
    status: places.map(() => 'waiting'), x_mm: places.map(([x]) => x), y_mm: places.map(([, y]) => y),
    seconds: places.map(() => null), tries: places.map(() => 0), message: places.map(() => ''),
  })
  return made
}

test('a snake over a grid has every point in its own cell, in spite of 0.30000000000000004', () => {
  const snake: [number, number][] = [[0, 0], [0.1, 0], [0.1 + 0.2, 0], [0.3, 0.5], [0.1, 0.5], [0, 0.5]]
  const layout = layoutOf(table(snake))

  expect([layout.width, layout.height]).toEqual([3, 2])
  expect([...layout.cell]).toEqual([0, 1, 2, 5, 4, 3])
  expect([...layout.point]).toEqual([0, 1, 2, 5, 4, 3])
  expect(layout.x).toEqual([0, 0.1, 0.3])
})

test('cells without a point are known as such', () => {
  const layout = layoutOf(table([[0, 0], [1, 1]]))

  expect([...layout.point]).toEqual([0, -1, -1, 1])
})

test('points without positions, and scattered points, are in rows of squares', () => {
  const loop = layoutOf(table([[NaN, NaN], [NaN, NaN], [NaN, NaN]]))
  const strewn = layoutOf(table(Array.from({ length: 100 }, (_, i) => [i * 1.37, (i * 7919) % 101])))

  expect([loop.width, loop.height]).toEqual([3, 1])
  expect([strewn.width, strewn.height, strewn.x]).toEqual([15, 7, []])
  expect(strewn.cell[0]).toBe(6 * 15)
})

test('a loop that has no points yet has a layout', () => {
  expect(layoutOf(new PointTable('main/hunt')).width).toBe(1)
})
