// Remove a structure and leave its steps in its place.
import { land, refused, type Change, type Patch } from './land'
import { chunkOf, columnOf, shift } from './lines'
import { COMPACT, listPlaceAt } from './listing'
import { isMap, valueAt, type Path } from './path'
import { placeAt, type Place } from './place'
import { copyOf, listAt } from './plain'
import { commentsOf, type Read } from './reading'
import { kindOf, type StepKind } from './steps'

/** The key under which a structure holds its steps; null for kinds without steps. */
export function innerKey(kind: StepKind | null): string | null {
  if (kind === 'if') return 'then'
  if (kind === 'parallel' || kind === 'any') return kind
  return kind !== null && ['foreach', 'repeat', 'while', 'steps'].includes(kind) ? 'steps' : null
}

/** Replace a structure by its steps; the comments of the removed parts go above them. */
export function unwrap(read: Read, path: Path): Patch {
  const at = path.at(-1)
  const from = path.slice(0, -1)
  const step = valueAt(read.data, path)
  const key = innerKey(kindOf(step))
  const inner = isMap(step) && key !== null ? step[key] : undefined
  const list = listPlaceAt(read, from)
  const innerPlace = placeAt(read.root, [...path, key ?? ''])
  if (typeof at !== 'number' || !list || !Array.isArray(inner) || !innerPlace) return refused('this step contains no other steps')
  if (inner.length === 0) return refused('it is empty')
  if (isMap(step) && Array.isArray(step['else'])) return refused('it has two branches: move the steps out of one of them first')
  const data = copyOf(read.data)
  listAt(data, from)?.splice(at, 1, ...(copyOf(inner) as unknown[]))
  const intent = { data, select: path }
  const change = list.place.flow ? unwrappedFlow(read, list.place, at, innerPlace) : unwrappedLines(read, list.place, at, innerPlace)
  return change ? land(read, [change], intent) : refused(COMPACT)
}

function unwrappedFlow({ text }: Read, list: Place, at: number, inner: Place): Change | null {
  const item = list.items[at]
  const [first, last] = [inner.items[0], inner.items.at(-1)]
  return item && first && last && inner.flow ? { from: item.start, to: item.end, insert: text.slice(first.start, last.end) } : null
}

function unwrappedLines(read: Read, list: Place, at: number, inner: Place): Change | null {
  const { text } = read
  const chunk = chunkOf(text, list, at)
  const column = columnOf(text, list.items[at]?.start ?? 0)
  const margin = ' '.repeat(column)
  const kept = spanOf(text, inner)
  if (!chunk || !kept) return null
  const lines = inner.flow
    ? inner.items.map((item) => `${margin}- ${text.slice(item.start, item.end)}`).join('\n')
    : shift(text.slice(kept.from, kept.to), column - columnOf(text, inner.items[0]?.start ?? 0))
  const inside = (from: number): boolean => (inner.flow ? inner.items.some((item) => from >= item.start && from < item.end) : from >= kept.from && from < kept.to)
  const loose = commentsOf(text).filter(({ from }) => from >= chunk.from && from < chunk.to && !inside(from))
  return { from: chunk.from, to: chunk.to, insert: [...loose.map((comment) => `${margin}${comment.text}`), lines].join('\n') }
}

/** From the first item's lines to the end of the last one's. */
function spanOf(text: string, inner: Place): { from: number; to: number } | null {
  const [first, last] = [inner.items[0], inner.items.at(-1)]
  if (inner.flow) return first && last ? { from: first.start, to: last.end } : null
  const [from, to] = [chunkOf(text, inner, 0), chunkOf(text, inner, inner.items.length - 1)]
  return from && to && { from: from.from, to: to.to }
}
