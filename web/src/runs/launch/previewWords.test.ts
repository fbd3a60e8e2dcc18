import { expect, test } from 'vitest'
import type { Received } from '../../api/types'
import { amountWords, spanWords, timeWords } from './previewWords'

const preview = (more: object): Received<'Preview'> =>
  ({ tracks: [], notes: [], full: false, actions: {}, actions_text: '', shots: null, needs_you: [], time_s: null, ...more }) as Received<'Preview'>
const now = new Date(2026, 10, 21, 12, 0, 0)

test('time is a range, with where it is from and when the run would end', () => {
  expect(timeWords(preview({ time_s: { low: 15_300, high: 16_800, runs: 3, real_s: null } }), now)).toBe(
    'Time: 4 h 15 min – 4 h 40 min (measured on 3 runs), ends 16:15–16:40',
  )
  expect(timeWords(preview({}), now)).toBe('Time: not known in advance')
  expect(spanWords({ low: 18, high: 18, runs: 0, real_s: 360 })).toBe('6 min (typical) with real devices; 18 s (typical) with these simulated ones')
  expect(spanWords({ low: 0, high: 0, runs: 0, real_s: 360 }, 300)).toBe('5 min (rehearsed) with real devices; a moment with these simulated ones')
  expect(spanWords({ low: 360, high: 360, runs: 0, real_s: null }, 300)).toBe('5 min (rehearsed)')
})

test('amounts are points, shots, and how often a person is needed', () => {
  const track = { x_mm: [1, 2, 3], outside: [1] }

  expect(amountWords(preview({ tracks: [track], shots: 1071, needs_you: ['ok?'] }))).toBe(
    '3 points · 1,071 laser shots · 1 outside the work area · needs you',
  )
})
