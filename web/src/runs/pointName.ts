// The name of a point: its number counted from 1, its position if it has one, otherwise its key.
import type { PointTable } from './points'

/** `point 413 (0.4, 1.6)`, `A · point 3`. */
export function pointName(table: PointTable, index: number): string {
  const within = table.within ? `${table.within} · ` : ''
  const [x, y] = [table.x[index], table.y[index]]
  const placed = x !== undefined && y !== undefined && !Number.isNaN(x) && !Number.isNaN(y)
  const key = table.keys[index]
  const more = placed ? ` (${place(x)}, ${place(y)})` : key != null && key !== String(index) ? ` ${key}` : ''
  return `${within}point ${(index + 1).toLocaleString('en')}${more}`
}

function place(mm: number): string {
  return String(Math.round(mm * 1000) / 1000)
}
