import { expect, test } from 'vitest'
import type { RunSummary } from '../api/types'
import { sortedRuns } from './sortedRuns'

const run = (id: string, more: Partial<RunSummary>): RunSummary =>
  ({ id, protocol: 'libs-grid', file: '', operator: '', fate: 'succeeded', began_at: '', reason: '', live: false, ...more }) as RunSummary
const RUNS = [
  run('a', { began_at: '2026-11-20T10:00:00Z', operator: 'Ada' }),
  run('b', { began_at: '2026-11-21T10:00:00Z', fate: 'failed' }),
  run('c', { began_at: '2026-11-19T10:00:00Z', live: true, fate: 'running' }),
  run('d', {}),
]

test('live runs come first, then the newest', () => {
  expect(sortedRuns(RUNS).map((one) => one.id)).toEqual(['c', 'd', 'b', 'a'])
})
