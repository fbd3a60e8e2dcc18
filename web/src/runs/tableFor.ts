// From an address to the points it refers to.
import type { RunPicture } from './picture'
import type { PointTable } from './points'

/** The table with this id, or the first that has points if none is named. */
export function tableFor(run: RunPicture, id: unknown): PointTable | null {
  const tables = run.filled()
  return tables.find((table) => table.id === id) ?? (id === undefined ? (tables[0] ?? null) : null)
}

/** The points to show by default: the innermost active loop, otherwise the largest. */
export function tableOfNow(tables: readonly PointTable[]): PointTable | null {
  const depth = (table: PointTable): number => table.loop.split('*').length
  const busy = tables.filter((table) => table.size > 1 && table.count('running') > 0)
  const [first] = busy.length ? busy.sort((a, b) => depth(b) - depth(a)) : [...tables].sort((a, b) => b.size - a.size)
  return first ?? null
}

/** The point of a loop by its key, as log lines and actions name it; the newest iteration first. */
export function pointOf(
  run: RunPicture, loop: string | null, key: string | null,
): { table: PointTable; index: number } | null {
  if (loop === null || key === null) return null
  for (const table of [...(run.tables.get(loop) ?? [])].reverse()) {
    const index = table.indexOf(key)
    if (index !== undefined) return { table, index }
  }
  return null
}
