import { expect, test } from 'vitest'
import type { Received } from '../../api/types'
import { amountWords, timeWords } from './previewWords'

const preview = (more: object): Received<'Preview'> =>
  ({ tracks: [], notes: [], full: false, actions: {}, actions_text: '', shots: null, needs_you: [], time_s: null, ...more }) as Received<'Preview'>
const now = new Date(2026, 10, 21, 12, 0, 0)

test('time is a range, with where it is from and when the run would end', () => {
  expect(timeWords(preview({ time_s: { low: 15_300, high: 16_800, runs: 3 } }), now)).toBe(
    'Time 4 h 15 min – 4 h 40 min (measured on 3 runs), ends 16:15–16:40',
  )
  expect(timeWords(preview({}), now)).toBe('Time: not known in advance')
})

test('amounts are points, shots, and how often a person is needed', () => {
  const track = { x_mm: [1, 2, 3], outside: [1] }

  expect(amountWords(preview({ tracks: [track], shots: 1071, needs_you: ['ok?'] }))).toBe(
    '3 points · 1,071 laser shots · 1 outside the work area · needs you 1×',
  )
})
