// The list of runs: live ones first, then the newest; searchable by any of their text.
import type { RunSummary } from '../api/types'

/** Runs in which every word of `find` occurs, in the order in which they are shown. */
export function sortedRuns(runs: readonly RunSummary[], find: string): RunSummary[] {
  const words = find.toLowerCase().split(/\s+/).filter(Boolean)
  return runs
    .filter((run) => {
      const text = `${run.id} ${run.protocol} ${run.file} ${run.operator} ${run.fate} ${run.began_at} ${run.reason}`.toLowerCase()
      return words.every((word) => text.includes(word))
    })
    .sort((a, b) => Number(b.live) - Number(a.live) || order(b).localeCompare(order(a)))
}

/** A run without a start time yet is the newest. */
function order(run: RunSummary): string {
  return run.began_at || '9'
}
