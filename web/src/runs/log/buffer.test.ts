import { expect, test } from 'vitest'
import { appended, fits, prepended, type LogLine } from './buffer'

const line = (n: number, more: Partial<LogLine> = {}): LogLine =>
  ({ n, at: '', level: 'info', kind: 'ended', text: `line ${n}`, device: 'libs', path: '', node: null, loop: null, key: null, line: null, ...more })

test('no line appears twice', () => {
  const lines = appended([line(1), line(4)], [line(4), line(9)])

  expect(lines.map((one) => one.n)).toEqual([1, 4, 9])
  expect(prepended(lines, [line(0), line(1)]).map((one) => one.n)).toEqual([0, 1, 4, 9])
})

test('the oldest lines go when there are too many', () => {
  expect(appended([line(1), line(2)], [line(3)], 2).map((one) => one.n)).toEqual([2, 3])
})

test('a new line is checked against the filter', () => {
  const all = { problems: false, device: '', find: '' }

  expect(fits(line(1), all)).toBe(true)
  expect(fits(line(1), { ...all, problems: true })).toBe(false)
  expect(fits(line(1), { ...all, device: 'gantry' })).toBe(false)
  expect(fits(line(12, { text: 'No Plasma' }), { ...all, find: 'no pl' })).toBe(true)
})
