// Outlines as a depth camera reports them, or by three corners, and as a table that a protocol reads.
import { api, read } from '../../api/client'
import { isMap } from '../text/path'
import type { Box, Spot } from './drawing'

/** Its centre is its place. */
export interface Sample extends Spot {
  /** Corners in mm, one after the other. */
  outline: readonly Spot[]
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

/** The outline through three corners, one after the other: the fourth lies opposite the second. Null if they are in one line. */
export function throughThree([a, b, c]: readonly [Spot, Spot, Spot]): readonly Spot[] | null {
  const across = Math.abs((b.x - a.x) * (c.y - b.y) - (b.y - a.y) * (c.x - b.x))
  const longest = Math.max(Math.hypot(b.x - a.x, b.y - a.y), Math.hypot(c.x - b.x, c.y - b.y))
  return across > 0.1 * longest ? [a, b, c, { x: a.x + c.x - b.x, y: a.y + c.y - b.y }] : null
}

/** To the hundredth of a millimetre: no camera sees finer. */
export function outlineTable(outline: readonly Spot[]): string {
  return ['x (mm),y (mm)', ...outline.map(({ x, y }) => `${String(round(x))},${String(round(y))}`)].join('\n') + '\n'
}

/** Keep it as a table beside the protocol; returns the table's name. */
export async function keepOutline(protocol: string, outline: readonly Spot[]): Promise<string> {
  return (await read(api.POST('/api/v1/tables', { body: { protocol, name: 'outline.csv', text: outlineTable(outline) } }))).name
}

/** The smallest box around it, in whole tenths of a millimetre. */
export function boxAround(outline: readonly Spot[]): Box {
  const [xs, ys] = [outline.map(({ x }) => round(10 * x)), outline.map(({ y }) => round(10 * y))]
  const [x, y] = [Math.floor(Math.min(...xs)) / 10, Math.floor(Math.min(...ys)) / 10]
  return { x, y, width: round(Math.ceil(Math.max(...xs)) / 10 - x), height: round(Math.ceil(Math.max(...ys)) / 10 - y) }
}

function round(mm: number): number {
  return Math.round(100 * mm) / 100
}
