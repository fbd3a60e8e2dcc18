// Outlines as a depth camera reports them, and as a table that a protocol reads.
import { isMap } from '../text/path'
import type { Box } from './drawing'

export interface Sample {
  /** Corners in mm, one after the other. */
  outline: readonly { x: number; y: number }[]
  /** Its centre in mm. */
  x: number
  y: number
}

/** What `locate_samples` returned; what is no outline is left out. */
export function samplesOf(result: unknown): Sample[] {
  const samples = isMap(result) && Array.isArray(result['samples']) ? (result['samples'] as unknown[]) : []
  return samples.flatMap((one) => {
    if (!isMap(one) || !Array.isArray(one['outline'])) return []
    const outline = (one['outline'] as unknown[]).flatMap((at) => (isMap(at) ? [{ x: Number(at['x']), y: Number(at['y']) }] : []))
    const sound = outline.length >= 3 && outline.every(({ x, y }) => Number.isFinite(x) && Number.isFinite(y))
    return sound ? [{ outline, x: Number(one['x']), y: Number(one['y']) }] : []
  })
}

/** To the hundredth of a millimetre: no camera sees finer. */
export function outlineTable({ outline }: Sample): string {
  return ['x (mm),y (mm)', ...outline.map(({ x, y }) => `${String(round(x))},${String(round(y))}`)].join('\n') + '\n'
}

/** The smallest box around it, in whole tenths of a millimetre. */
export function boxAround({ outline }: Sample): Box {
  const [xs, ys] = [outline.map(({ x }) => x), outline.map(({ y }) => y)]
  const [x, y] = [Math.floor(10 * Math.min(...xs)) / 10, Math.floor(10 * Math.min(...ys)) / 10]
  return { x, y, width: round(Math.ceil(10 * Math.max(...xs)) / 10 - x), height: round(Math.ceil(10 * Math.max(...ys)) / 10 - y) }
}

function round(mm: number): number {
  return Math.round(100 * mm) / 100
}
