// Where each point of a loop is on the map: on its grid, or in rows of squares if it has no position.
import type { PointTable } from '../points'

export interface Layout {
  /** Cells across and up; `cell[index]` counts row by row from the lowest y. */
  width: number
  height: number
  cell: Int32Array
  /** Index of the point in each cell, -1 for none. */
  point: Int32Array
  /** Positions of columns and rows in mm; empty if points have none. */
  x: number[]
  y: number[]
}

const ROUND = 1e4

/** The layout of a table: a grid by x and y, unless most cells would stay empty. */
export function layoutOf(table: PointTable): Layout {
  const placed = table.size > 0 && allPlaced(table)
  const x = placed ? steps(table.x, table.size) : []
  const y = placed ? steps(table.y, table.size) : []
  if (!placed || x.length * y.length > 8 * table.size + 64) return inRows(table.size)
  const columns = new Map(x.map((at, i) => [at, i]))
  const rows = new Map(y.map((at, i) => [at, i]))
  const cell = new Int32Array(table.size)
  for (let i = 0; i < table.size; i++) {
    const column = columns.get(rounded(table.x[i])) ?? 0
    cell[i] = (rows.get(rounded(table.y[i])) ?? 0) * x.length + column
  }
  return { width: x.length, height: y.length, cell, point: inverse(cell, x.length * y.length), x, y }
}

function allPlaced(table: PointTable): boolean {
  for (let i = 0; i < table.size; i++)
    if (Number.isNaN(table.x[i]) || Number.isNaN(table.y[i])) return false
  return true
}

function steps(places: Float64Array, size: number): number[] {
  const found = new Set<number>()
  for (let i = 0; i < size; i++) found.add(rounded(places[i]))
  return [...found].sort((a, b) => a - b)
}

function rounded(place: number | undefined): number {
  return Math.round((place ?? 0) * ROUND) / ROUND
}

/** Points without positions: squares in a wide rectangle, the first on top. */
function inRows(size: number): Layout {
  const width = Math.max(1, Math.ceil(Math.sqrt(size * 2)))
  const height = Math.max(1, Math.ceil(size / width))
  const cell = Int32Array.from({ length: size }, (_, i) => (height - 1 - Math.floor(i / width)) * width + (i % width))
  return { width, height, cell, point: inverse(cell, width * height), x: [], y: [] }
}

function inverse(cell: Int32Array, cells: number): Int32Array {
  const point = new Int32Array(cells).fill(-1)
  cell.forEach((at, index) => (point[at] = index))
  return point
}
