import { expect, test } from 'vitest'
import type { RunHead } from './picture'
import { aloud, needsYouWords, pace, stripWords } from './stripWords'

const now = new Date(2026, 10, 21, 14, 0, 0)
const iso = (h: number, m: number): string => new Date(2026, 10, 21, h, m).toISOString()
const head = (more: Partial<RunHead>): RunHead =>
  ({
    protocol: 'libs-grid', fate: 'running', live: true, done: 413, measured: 412, failed: 1, left: 658, total: 1071, per_minute: 3.912, retries: 2,
    holes: 1, resumes: 0, eta: [iso(16, 10), iso(16, 25)], open_questions: [], needs_you: null, ...more,
  }) as RunHead

test('the strip shows progress, pace, end time and failures', () => {
  expect(stripWords(head({}), now)).toEqual(['412 of 1,071 measured', '1 failed', '658 left', '3.91/min', 'ends 16:10–16:25', '2 retries'])
  expect(stripWords(head({ live: false }), now)).toEqual(['412 of 1,071 measured', '1 failed', '658 left', '2 retries'])
})

test('a slow run shows how long one point takes', () => {
  expect(pace(0.5)).toBe('2 min per point')
  expect(pace(0.5 / 60)).toBe('2 h 00 min per point')
})

test('when a person will be needed is shown in advance', () => {
  const needs_you = { text: 'change the sample', low: iso(14, 12), high: iso(14, 20) }

  expect(needsYouWords(head({ needs_you }), now)).toBe('next needs you: 14:12–14:20 (in 12 min), change the sample')
})

test('a question is announced before anything else', () => {
  const open_questions = [{ path: 'p', id: 'q', text: 'Clamped?', choices: ['yes'], wants: {} }]

  expect(aloud(head({ open_questions }))).toBe('The run asks: Clamped?')
  expect(aloud(head({ failed: 2, left: 657 }))).toBe('libs-grid running, 412 of 1,071 measured, 2 failed, 657 left')
})
