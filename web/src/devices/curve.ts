// A table of two number columns as a curve, thinned to what a small picture can show.

export interface Curve {
  points: string
  words: string
}

const WIDTH = 600
const HEIGHT = 160
const MARGIN = 6

/** The first two columns; null if the text is not such a table. Peaks survive the thinning. */
export function curveOf(csv: string): Curve | null {
  const lines = csv.split(/\r?\n/).filter((line) => line !== '' && !line.startsWith('#'))
  const rows = lines.map((line) => line.split(/[,;\t]/).slice(0, 2).map(Number))
  const known = rows.filter((row): row is [number, number] => row.length === 2 && row.every((one) => Number.isFinite(one)))
  if (known.length < 8) return null
  const xs = known.map(([x]) => x)
  const ys = known.map(([, y]) => y)
  const [x0, x1] = [least(xs), most(xs)]
  const [y0, y1] = [Math.min(0, least(ys)), most(ys)]
  if (x1 <= x0 || y1 <= y0) return null
  const across = (x: number): number => ((x - x0) / (x1 - x0)) * WIDTH
  const up = (y: number): number => HEIGHT - MARGIN - ((y - y0) / (y1 - y0)) * (HEIGHT - 2 * MARGIN)
  const points = thinned(known, x0, x1).map(([x, y]) => `${across(x).toFixed(1)},${up(y).toFixed(1)}`)
  const peak = known.reduce((best, one) => (one[1] > best[1] ? one : best))
  const words = `${known.length} values from ${x0.toFixed(1)} to ${x1.toFixed(1)}, most ${peak[1].toFixed(0)} at ${peak[0].toFixed(2)}`
  return { points: points.join(' '), words }
}

/** Lowest and highest of each pixel column. */
function thinned(rows: readonly [number, number][], x0: number, x1: number): [number, number][] {
  const columns = new Map<number, { low: [number, number]; high: [number, number] }>()
  for (const row of rows) {
    const column = Math.floor(((row[0] - x0) / (x1 - x0)) * WIDTH)
    const known = columns.get(column)
    if (known === undefined) columns.set(column, { low: row, high: row })
    else if (row[1] < known.low[1]) known.low = row
    else if (row[1] > known.high[1]) known.high = row
  }
  return [...columns.entries()].sort(([a], [b]) => a - b).flatMap(([, { low, high }]) => (low === high ? [low] : [low, high]))
}

const least = (values: readonly number[]): number => values.reduce((a, b) => Math.min(a, b), Infinity)
const most = (values: readonly number[]): number => values.reduce((a, b) => Math.max(a, b), -Infinity)
