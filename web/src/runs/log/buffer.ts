// The log lines on the page: in order, each once, as many as a page can hold.
import type { Received } from '../../api/types'

export type LogLine = Received<'LogLine'>

export const MOST = 1000

export interface Filter {
  problems: boolean
  device: string
  find: string
}

/** Whether a new line passes the filter; the server filters the old ones in the same way. */
export function fits(line: LogLine, filter: Filter): boolean {
  if (filter.problems && line.level !== 'problem') return false
  if (filter.device && line.device !== filter.device) return false
  return !filter.find || line.text.toLowerCase().includes(filter.find.toLowerCase())
}

/** Append newer lines; the oldest are dropped when there are too many. */
export function appended(lines: readonly LogLine[], newer: readonly LogLine[], most = MOST): LogLine[] {
  const last = lines.at(-1)?.n ?? -1
  const more = newer.filter((line) => line.n > last)
  return more.length ? [...lines, ...more].slice(-most) : [...lines]
}

/** Prepend older lines. */
export function prepended(lines: readonly LogLine[], older: readonly LogLine[]): LogLine[] {
  const first = lines[0]?.n ?? Infinity
  return [...older.filter((line) => line.n < first), ...lines]
}
