// The points of a run that failed, and can be measured again.
import type { RunPicture } from './picture'
import type { PointTable } from './points'

export interface HolePoint {
  table: PointTable
  index: number
}

/** All of them, in the order of their loops; of a hole with holes inside, only itself. */
export function holesOf(run: RunPicture): HolePoint[] {
  const found: HolePoint[] = []
  for (const table of [...run.tables.values()].flat()) {
    if (!table.loop.startsWith('main') || isInHole(run, table)) continue
    for (let index = 0; index < table.size; index++) if (table.status(index) === 'failed') found.push({ table, index })
  }
  return found
}

export const holeId = ({ table, index }: HolePoint): string => `${table.id}#${index}`

/** As the server wants it. */
export function holeAt({ table, index }: HolePoint): { loop: string; within: string; key: string } {
  return { loop: table.loop, within: table.within, key: table.keys[index] ?? '' }
}

function isInHole(run: RunPicture, table: PointTable): boolean {
  const loops = table.loop.split('/*/')
  const keys = table.within ? table.within.split('/') : []
  return keys.some((key, depth) => {
    const around = run.tables.get(loops.slice(0, depth + 1).join('/*/'))?.find((one) => one.within === keys.slice(0, depth).join('/'))
    const index = around?.indexOf(key)
    return around !== undefined && index !== undefined && around.status(index) === 'failed'
  })
}
