import { expect, test } from 'vitest'
import { cellsInBox, cellsInLasso } from './lasso'

const plane = { width: 5, height: 4 }

test('a box includes its corners, from whichever corner it was drawn', () => {
  const down = cellsInBox(plane, { x: 1, y: 2 }, { x: 2, y: 1 })
  const up = cellsInBox(plane, { x: 2, y: 1 }, { x: 1, y: 2 })

  expect(down).toEqual([6, 7, 11, 12])
  expect(up).toEqual(down)
})

test('a box that reaches over the edge takes only existing cells', () => {
  expect(cellsInBox(plane, { x: -9, y: -9 }, { x: 0.4, y: 0.4 })).toEqual([0])
})

test('a triangle takes the centres inside it', () => {
  const triangle = [{ x: -0.5, y: -0.5 }, { x: 4.5, y: -0.5 }, { x: -0.5, y: 3.5 }]

  expect(cellsInLasso(plane, triangle)).toEqual([0, 1, 2, 3, 5, 6, 7, 10, 11, 15].filter((c) => inside(c)))
})

function inside(cell: number): boolean {
  const [x, y] = [cell % 5, Math.floor(cell / 5)]
  return (x + 0.5) / 5 + (y + 0.5) / 4 < 1
}

test('a line that crosses itself leaves its hole out', () => {
  const ring = [
    { x: -1, y: -1 }, { x: 5, y: -1 }, { x: 5, y: 4 }, { x: -1, y: 4 }, { x: -1, y: -1 },
    { x: 0.5, y: 0.5 }, { x: 3.5, y: 0.5 }, { x: 3.5, y: 2.5 }, { x: 0.5, y: 2.5 }, { x: 0.5, y: 0.5 },
  ]
  const found = new Set(cellsInLasso(plane, ring))

  expect(found.has(0)).toBe(true)
  expect(found.has(7)).toBe(false)
})

test('a click is not a lasso', () => {
  expect(cellsInLasso(plane, [{ x: 1, y: 1 }])).toEqual([])
})
