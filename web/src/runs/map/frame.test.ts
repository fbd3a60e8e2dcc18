import { expect, test } from 'vitest'
import { cellAt, frameIn, moved, placeAt, rectOf } from './frame'

const frame = frameIn(210, 510, 21, 51)

test('a map is as large as fits, and its first cell is the lowest left one', () => {
  expect(frame.cellX).toBe(10)
  expect(rectOf(frame, 0)).toEqual([0, 500, 10, 10])
  expect(rectOf(frame, 21 * 51 - 1)).toEqual([200, 0, 10, 10])
})

test('a click finds the cell that is drawn there', () => {
  for (const cell of [0, 20, 21, 500, 1070]) {
    const [x, y, w, h] = rectOf(frame, cell)

    expect(cellAt(frame, x + w / 2, y + h / 2)).toBe(cell)
    expect(cellAt(frame, x + 0.1, y + 0.1)).toBe(cell)
  }
})

test('there is no cell outside', () => {
  const small = frameIn(600, 600, 2, 2)

  expect(cellAt(small, 1, 1)).toBe(-1)
  expect(placeAt(small, 300, 300)).toEqual({ x: 0.5, y: 0.5 })
})

test('arrows move the cursor as on the bench: up is towards higher y', () => {
  expect(moved(frame, 22, 'ArrowUp')).toBe(43)
  expect(moved(frame, 22, 'ArrowLeft')).toBe(21)
  expect(moved(frame, 0, 'ArrowDown')).toBe(0)
  expect(moved(frame, 22, 'End')).toBe(41)
  expect(moved(frame, 22, 'a')).toBeNull()
})
