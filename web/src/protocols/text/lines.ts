// Whole lines around a place: the comments above that belong to it, and where its last line ends.
import type { Item, Place } from './place'

export function lineStart(text: string, at: number): number {
  return text.lastIndexOf('\n', at - 1) + 1
}

/** The end of the line without its line break. */
export function lineEnd(text: string, at: number): number {
  const found = text.indexOf('\n', at)
  const end = found < 0 ? text.length : found
  return end > at && text.charAt(end - 1) === '\r' ? end - 1 : end
}

export function columnOf(text: string, at: number): number {
  return at - lineStart(text, at)
}

/** Whether only spaces precede it on its line. */
export function beginsLine(text: string, at: number): boolean {
  return text.slice(lineStart(text, at), at).trim() === ''
}

/** The lines of an item of a block list: its own comments above, itself, deeper comments below. */
export interface Chunk {
  from: number
  to: number
}

export function chunkOf(text: string, list: Place, index: number): Chunk | null {
  const item = list.items[index]
  if (!item || list.flow || !beginsLine(text, item.start)) return null
  const before = list.items[index - 1]
  const floor = before ? tailEnd(text, before, columnOf(text, before.start)) : 0
  return { from: leadStart(text, item.start, floor), to: tailEnd(text, item, columnOf(text, item.start)) }
}

/** Where the comment lines directly above, at the same column, begin. */
function leadStart(text: string, at: number, floor: number): number {
  const column = columnOf(text, at)
  let from = lineStart(text, at)
  while (from > floor) {
    const above = lineStart(text, from - 1)
    const line = text.slice(above, from)
    if (above < floor || indentOf(line) !== column || line.charAt(column) !== '#') break
    from = above
  }
  return from
}

/** The end of its last line, and of the comment lines below that are indented deeper than `column`. */
export function tailEnd(text: string, item: Item, column: number): number {
  let to = lineEnd(text, item.end)
  for (;;) {
    const next = text.indexOf('\n', to) + 1
    if (next === 0) return to
    const end = lineEnd(text, next)
    const line = text.slice(next, end)
    const indent = indentOf(line)
    if (line.charAt(indent) !== '#' || indent <= column) return to
    to = end
  }
}

export function indentOf(line: string): number {
  return /^ */.exec(line)?.[0].length ?? 0
}

/** Move lines to the right, or to the left as far as they have spaces; the first line as well. */
export function shift(lines: string, by: number): string {
  if (by === 0) return lines
  return lines
    .split('\n')
    .map((line) => {
      if (line.trim() === '') return line
      return by > 0 ? ' '.repeat(by) + line : line.slice(Math.min(-by, indentOf(line)))
    })
    .join('\n')
}
