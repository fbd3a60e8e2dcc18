// From a place in the text to its row and back, and which rows are visible while others are closed.
import { toPointer, type Path } from './path'
import { itemAt, placeAt } from './place'
import type { Read } from './reading'
import type { Row } from './rows'

export class RowIndex {
  private readonly byStart: number[]
  private readonly byPointer = new Map<string, number>()

  constructor(readonly rows: readonly Row[]) {
    this.byStart = rows.map((_, i) => i)
    const start = (i: number): number => rows[i]?.from ?? 0
    if (rows.some((row, i) => i > 0 && row.from < start(i - 1))) this.byStart.sort((a, b) => start(a) - start(b) || a - b)
    for (const [i, row] of rows.entries()) this.byPointer.set(toPointer(row.path), i)
  }

  /** The innermost row that holds an offset; -1 if none does. */
  at(offset: number): number {
    let [low, high] = [0, this.byStart.length]
    while (low < high) {
      const middle = (low + high) >> 1
      if ((this.rows[this.byStart[middle] ?? 0]?.from ?? 0) <= offset) low = middle + 1
      else high = middle
    }
    let found = this.byStart[low - 1] ?? -1
    while (found >= 0 && (this.rows[found]?.to ?? 0) < offset) found = this.rows[found]?.parent ?? -1
    return found
  }

  /** The row of a path, or of the nearest step around it. */
  of(path: Path): number {
    for (let length = path.length; length >= 0; length--) {
      const found = this.byPointer.get(toPointer(path.slice(0, length)))
      if (found !== undefined) return found
    }
    return -1
  }
}

/** Where what stands on a line begins: the space and the dashes before it belong to the step around it. */
export function firstOn(line: string): number {
  return line.search(/[^\s-]|$/)
}

/** The numbers of the rows that are visible while those in `closed` (by pointer) are closed. */
export function seenRows(rows: readonly Row[], closed: ReadonlySet<string>): Int32Array {
  const seen = new Int32Array(rows.length)
  let count = 0
  for (let i = 0; i < rows.length; count++) {
    const row = rows[i]
    if (!row) break
    seen[count] = i
    const shut = row.end > i + 1 && closed.size > 0 && closed.has(toPointer(row.path))
    i = shut ? row.end : i + 1
  }
  return seen.subarray(0, count)
}

/** The position of the value at a path, or of its key if it has no value; null if there is neither. */
export function rangeOf(read: Read, path: Path): { from: number; to: number } | null {
  const part = path.at(-1)
  if (part === undefined) return read.root
  const item = itemAt(placeAt(read.root, path.slice(0, -1)), part)
  if (!item) return null
  return item.value.kind === 'empty' ? { from: item.start, to: item.keyEnd } : { from: item.value.from, to: item.value.to }
}

