// From a point's full key, as in maps and tables, to its index among the points of its loop.
import type { RunPicture } from '../runs/picture'
import type { PointTable } from '../runs/points'

/** `A/0,0` is `0,0` within `A`; null if no such point is known. */
export function placeOfKey(run: RunPicture, loop: string | null, key: string): { table: PointTable; index: number } | null {
  const tables = loop === null ? run.filled() : (run.tables.get(loop) ?? [])
  for (const table of tables) {
    const own = table.within ? (key.startsWith(`${table.within}/`) ? key.slice(table.within.length + 1) : null) : key
    const index = own === null ? undefined : table.indexOf(own)
    if (index !== undefined) return { table, index }
  }
  return null
}

/** The other way: how maps, tables and addresses call a point. */
export function keyOfPlace({ within, keys }: PointTable, index: number): string {
  return [within, keys[index]].filter(Boolean).join('/')
}
