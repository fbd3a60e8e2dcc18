// Insert, remove, move and copy items of lists: whole lines, with their comments.
import { intoFlow, outOfFlow } from './flow'
import { land, refused, type Change, type Patch } from './land'
import { chunkOf, columnOf, lineEnd, shift, type Chunk } from './lines'
import type { Path } from './path'
import { itemAt, placeAt, type Item, type Place } from './place'
import { copyOf, listAt } from './plain'
import type { Read } from './reading'
import { writeFlow, writeItems } from './write'

export const COMPACT = 'this list begins on the same line as another one: edit it in YAML'

/** The list with the item that contains it; null if its key would first have to be created. */
export interface ListPlace {
  place: Place
  owner: Item | null
  /** Whether it is itself between brackets, where no lines can begin. */
  inFlow: boolean
}

export function listPlaceAt(read: Read, path: Path): ListPlace | null {
  const place = placeAt(read.root, path)
  const part = path.at(-1)
  if (!place || part === undefined) return null
  const parent = placeAt(read.root, path.slice(0, -1))
  return { place, owner: itemAt(parent, part) ?? null, inFlow: read.json || parent?.flow === true }
}

/** New items before the one at `index`. */
export function insertItems(read: Read, path: Path, index: number, values: readonly unknown[]): Patch {
  const list = listPlaceAt(read, path)
  if (!list) return refused('there is no such list')
  const data = copyOf(read.data)
  const items = listAt(data, path)
  if (!items || index < 0 || index > items.length) return refused('there is no such place in the list')
  items.splice(index, 0, ...values.map(copyOf))
  const changes = inserting(read, list, index, (column) => writeItems(values, column), () => values.map((value) => writeFlow(value, read.json)).join(', '))
  return changes ? land(read, changes, { data, select: [...path, index] }) : refused(COMPACT)
}

export type AsLines = (column: number) => string
export type AsFlow = () => string | null

/** The changes that put lines (dash at `column`), or flow text, before the item at `index`. */
export function inserting(read: Read, list: ListPlace, index: number, lines: AsLines, flow: AsFlow): Change[] | null {
  const { text } = read
  const { place } = list
  if (place.flow && (place.items.length > 0 || list.inFlow || list.owner?.key == null)) {
    const written = flow()
    return written === null ? null : [intoFlow(place, index, written)]
  }
  if (place.items.length === 0) return intoEmpty(read, list, lines)
  const column = columnOf(text, place.items[0]?.start ?? 0)
  const margin = ' '.repeat(column)
  const gap = '\n'.repeat(usualGap(text, place))
  if (index === 0) {
    const first = chunkOf(text, place, 0)
    return first && [{ from: first.from, to: first.from, insert: margin + lines(column) + gap }]
  }
  const before = chunkOf(text, place, index - 1)
  return before && [{ from: before.to, to: before.to, insert: gap + margin + lines(column) }]
}

/** `[]`, or nothing after the colon, becomes a list of lines below. */
function intoEmpty({ text }: Read, { place, owner, inFlow }: ListPlace, lines: AsLines): Change[] | null {
  if (owner?.key == null || inFlow || place.special) return null
  const column = columnOf(text, owner.start) + 2
  const end = lineEnd(text, owner.end)
  const below = { from: end, to: end, insert: `\n${' '.repeat(column)}${lines(column)}` }
  return place.kind === 'empty' ? [below] : [{ from: owner.mark, to: place.to, insert: '' }, below]
}

/** 2 if blank lines separate all items, otherwise 1. */
function usualGap(text: string, list: Place): 1 | 2 {
  if (list.items.length < 2) return 1
  for (let i = 1; i < Math.min(list.items.length, 12); i++) {
    const before = chunkOf(text, list, i - 1)
    const here = chunkOf(text, list, i)
    if (before && here && !/\n[ ]*\n/.test(text.slice(before.to, here.from))) return 1
  }
  return 2
}

/** Remove an item with its comments; `[]` is left if it was the only one. */
export function removeItem(read: Read, path: Path): Patch {
  const listPath = path.slice(0, -1)
  const index = path.at(-1)
  const list = listPlaceAt(read, listPath)
  if (typeof index !== 'number' || !list?.place.items[index]) return refused('there is no such step')
  const data = copyOf(read.data)
  listAt(data, listPath)?.splice(index, 1)
  const changes = removing(read, list, index)
  const left = list.place.items.length - 1
  const select = left === 0 ? listPath.slice(0, -1) : [...listPath, Math.min(index, left - 1)]
  return changes ? land(read, changes, { data, select, mayLose: true }) : refused(COMPACT)
}

export function removing({ text }: Read, { place, owner }: ListPlace, index: number): Change[] | null {
  if (place.flow) return [outOfFlow(place, index)]
  const chunk = chunkOf(text, place, index)
  if (!chunk) return null
  if (place.items.length === 1) {
    if (!owner) return null
    return [{ from: owner.mark, to: owner.mark, insert: ' []' }, { from: Math.max(chunk.from - 1, owner.mark), to: chunk.to, insert: '' }]
  }
  return [{ ...goneLines(text, place, index, chunk), insert: '' }]
}

/** Its lines with the blank ones after it, or before it for the last; comments between stay. */
function goneLines(text: string, place: Place, index: number, chunk: Chunk): Chunk {
  const next = chunkOf(text, place, index + 1)
  if (next) return { from: chunk.from, to: text.slice(chunk.to, next.from).includes('#') ? chunk.to + 1 : next.from }
  const before = chunkOf(text, place, index - 1)
  if (before && !text.slice(before.to, chunk.from).includes('#')) return { from: before.to, to: chunk.to }
  return { from: Math.max(chunk.from - 1, 0), to: chunk.to }
}

/** The item's lines from its dash on, without the margin, or its text between brackets. */
export function bodyOf({ text }: Read, place: Place, index: number): string | null {
  const item = place.items[index]
  if (!item) return null
  if (place.flow) return `- ${text.slice(item.start, item.end)}`
  const chunk = chunkOf(text, place, index)
  return chunk && text.slice(chunk.from, chunk.to).slice(columnOf(text, item.start))
}

export function movedLines(body: string, from: number): AsLines {
  return (column) => shift(body, column - from).trimStart()
}
