import { expect, test } from 'vitest'
import { ROW_PX, scrollTo, shownRows } from './scroll'

test('only what is in sight is drawn, with some more on each side', () => {
  const shown = shownRows(100_000, 50_000 * ROW_PX, 560)

  expect(shown.first).toBe(49_992)
  expect(shown.count).toBe(36)
  expect(shown.offsetPx).toBe(49_992 * ROW_PX)
})

test('the ends are ends', () => {
  expect(shownRows(3, 0, 560)).toEqual({ first: 0, count: 3, offsetPx: 0, tallPx: 3 * ROW_PX })
  expect(shownRows(0, 0, 560).count).toBe(0)
})

test('two million rows can all be reached, though no browser can draw them in one', () => {
  const size = 2_000_000
  const end = shownRows(size, 12_000_000 - 560, 560)

  expect(end.tallPx).toBe(12_000_000)
  expect(end.first + end.count).toBe(size)
})

test('a row out of sight says where to scroll', () => {
  expect(scrollTo(0, 100, 500, 280)).toBe(0)
  expect(scrollTo(99, 100, 0, 280)).toBe(100 * ROW_PX - 280)
  expect(scrollTo(3, 100, 0, 280)).toBeNull()
})
