// Two maps of the same places: what one has more than the other, and its colours.
import type { Pixels } from './mapImage'

interface Plane {
  width: number
  height: number
  x: readonly number[]
  y: readonly number[]
}

/** Places closer than this are one, in the maps' unit. */
const CLOSE = 1e-4

/** `other` minus `first` in the cells of `first`; NaN where one of them has nothing at the place. */
export function difference(first: Plane, ours: Float32Array, other: Plane, theirs: Float32Array): Float32Array {
  const columns = first.x.map((x) => other.x.findIndex((one) => Math.abs(one - x) < CLOSE))
  const rows = first.y.map((y) => other.y.findIndex((one) => Math.abs(one - y) < CLOSE))
  return ours.map((value, cell) => {
    const [column, row] = [columns[cell % first.width] ?? -1, rows[Math.floor(cell / first.width)] ?? -1]
    return column < 0 || row < 0 ? NaN : (theirs[row * other.width + column] ?? NaN) - value
  })
}

/** The largest size of a value; 1 where all are alike. */
export function largest(values: Float32Array): number {
  return values.reduce((most, value) => (Math.abs(value) > most ? Math.abs(value) : most), 0) || 1
}

/** Blue for less, white for alike, orange for more; the highest y on top. */
export function drawDifference(values: Float32Array, width: number, height: number, most: number): Pixels {
  const data = new Uint8ClampedArray(width * height * 4)
  values.forEach((value, cell) => {
    if (Number.isNaN(value)) return
    const share = Math.min(1, Math.abs(value) / most)
    const full = value > 0 ? [200, 90, 0] : [0, 80, 190]
    const at = ((height - 1 - Math.floor(cell / width)) * width + (cell % width)) * 4
    full.forEach((part, i) => (data[at + i] = 255 + (part - 255) * share))
    data[at + 3] = 255
  })
  return { width, height, data }
}
