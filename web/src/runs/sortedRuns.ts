// The list of runs: live ones first, then the newest.
import type { RunSummary } from '../api/types'

export function sortedRuns<T extends RunSummary>(runs: readonly T[]): T[] {
  return [...runs].sort((a, b) => Number(b.live) - Number(a.live) || order(b).localeCompare(order(a)))
}

/** A run without a start time yet is the newest. */
function order(run: RunSummary): string {
  return run.began_at || '9'
}
