// Move an item within its list or into another one, and copy it, with its comments.
import { after, land, refused, type Intent, type Patch } from './land'
import { chunkOf, columnOf } from './lines'
import { bodyOf, COMPACT, inserting, listPlaceAt, movedLines, removing, type ListPlace } from './listing'
import { samePath, startsWith, valueAt, type Path } from './path'
import { copyOf, listAt, pathOf } from './plain'
import { commentsOf, type Read } from './reading'
import { removeKey, setValue } from './setting'
import { OPTIONAL_LISTS } from './steps'
import { writeFlow } from './write'

/** Move the item at `path` before the item now at `index` of the list `to`. */
export function moveItem(read: Read, path: Path, to: Path, index: number): Patch {
  const from = path.slice(0, -1)
  const at = path.at(-1)
  const source = listPlaceAt(read, from)
  if (typeof at !== 'number' || !source?.place.items[at]) return refused('there is no such step')
  if (startsWith(to, path)) return refused('a step cannot be moved into itself')
  const target = listPlaceAt(read, to)
  if (!target) return after(setValue(read, to, []), (now) => moveItem(now, path, to, 0))
  const meant = intended(read, from, at, to, index)
  if (!meant) return refused('there is no such place in the list')
  if (samePath(from, to)) return moveWithin(read, source, at, index, meant.intent)
  const body = bodyOf(read, source.place, at)
  const out = removing(read, source, at)
  const into = body === null ? null : inserting(read, target, index, linesOf(read, source, at, body), () => flowOf(read, path, source, at))
  if (!into || !out) return refused(COMPACT)
  const patch = land(read, [...out, ...into], meant.intent)
  return source.place.items.length === 1 ? withoutEmpty(patch, read, meant.source) : patch
}

/** The intended data, and where the source list is then. */
function intended(read: Read, from: Path, at: number, to: Path, index: number): { intent: Intent; source: Path } | null {
  const data = copyOf(read.data)
  const source = listAt(data, from)
  const target = listAt(data, to)
  if (!source || !target || index < 0 || index > target.length) return null
  const [value] = source.splice(at, 1)
  target.splice(source === target && index > at ? index - 1 : index, 0, value)
  return { intent: { data, select: pathOf(data, value) ?? to }, source: pathOf(data, source) ?? from }
}

/** The lines of the item, between blank lines and comments that stay where they are. */
function moveWithin(read: Read, { place }: ListPlace, at: number, index: number, meant: Intent): Patch {
  const { text } = read
  const to = index > at ? index - 1 : index
  const spans = place.items.map((item, i) => (place.flow ? { from: item.start, to: item.end } : chunkOf(text, place, i)))
  const [here, there] = [spans[at], spans[to]]
  const [before, next] = [spans[at - 1], spans[at + 1]]
  if (to === at) return land(read, [], meant)
  if (!here || !there) return refused(COMPACT)
  const body = text.slice(here.from, here.to)
  if (to > at) {
    if (!next) return refused(COMPACT)
    const gap = text.slice(here.to, next.from)
    return land(read, [{ from: here.from, to: next.from, insert: '' }, { from: there.to, to: there.to, insert: gap + body }], meant)
  }
  if (!before) return refused(COMPACT)
  const gap = text.slice(before.to, here.from)
  return land(read, [{ from: there.from, to: there.from, insert: body + gap }, { from: before.to, to: here.to, insert: '' }], meant)
}

function linesOf(read: Read, { place }: ListPlace, at: number, body: string): (column: number) => string {
  const item = place.items[at]
  return place.flow || !item ? () => body : movedLines(body, columnOf(read.text, item.start))
}

/** Its text between brackets, or rewritten for them if no comment would be lost. */
function flowOf(read: Read, path: Path, { place }: ListPlace, at: number): string | null {
  const item = place.items[at]
  const chunk = chunkOf(read.text, place, at)
  if (place.flow && item) return read.text.slice(item.start, item.end)
  if (!chunk || commentsOf(read.text).some(({ from }) => from >= chunk.from && from < chunk.to)) return null
  return writeFlow(valueAt(read.data, path), read.json)
}

/** If an optional list becomes empty, its key is removed, too. */
function withoutEmpty(patch: Patch, read: Read, list: Path): Patch {
  if (!patch.ok || !OPTIONAL_LISTS.has(String(list.at(-1)))) return patch
  const gone = after(patch, (now) => removeKey(now, list))
  const kept = gone.ok && commentsOf(gone.text).length >= commentsOf(read.text).length
  return kept ? { ...gone, select: patch.select } : patch
}
