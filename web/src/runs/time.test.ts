import { expect, test } from 'vitest'
import { clock, clockRange, duration, etaWords, until } from './time'

const now = new Date(2026, 10, 21, 14, 3, 7)
const at = (h: number, m: number, s = 0, day = 21) => new Date(2026, 10, day, h, m, s)

test('durations have the figures that matter', () => {
  expect([0.012, 0.23, 6.14, 9.97, 59.4, 200, 3000, 14_760].map(duration)).toEqual([
    '12 ms', '0.2 s', '6.1 s', '10 s', '59 s', '3 min 20 s', '50 min', '4 h 06 min',
  ])
})

test('another day is shown', () => {
  expect(clock(at(16, 10), now)).toBe('16:10')
  expect(clock(at(1, 5, 0, 22), now)).toBe('tomorrow 01:05')
  expect(clock(at(1, 5, 0, 20), now)).toBe('yesterday 01:05')
  expect(clock(at(1, 5, 0, 3), now)).toBe('2026-11-03 01:05')
})

test('an end is a range, or one time if it is known to the minute', () => {
  expect(clockRange(at(16, 10), at(16, 25), now)).toBe('16:10–16:25')
  expect(clockRange(at(16, 10, 5), at(16, 10, 40), now)).toBe('16:10')
  expect(clockRange(at(23, 50), at(0, 20, 0, 22), now)).toBe('23:50–tomorrow 00:20')
  expect(clockRange(at(0, 5, 0, 22), at(0, 20, 0, 22), now)).toBe('tomorrow 00:05–00:20')
})

test('what ends within minutes is shown to the second', () => {
  expect(etaWords([at(14, 3, 20).toISOString(), at(14, 3, 40).toISOString()], now)).toBe('ends 14:03:20–14:03:40')
  expect(etaWords(null, now)).toBe('')
})

test('what is due is now', () => {
  expect(until(at(14, 3, 9), now)).toBe('now')
  expect(until(at(14, 15, 7), now)).toBe('in 12 min')
})
