// Copy a step: ids in the copy are new, and references to them inside it follow.
import { after, land, refused, type Change, type Patch } from './land'
import { chunkOf, lineStart } from './lines'
import { COMPACT, listPlaceAt, type ListPlace } from './listing'
import { valueAt, type Path } from './path'
import { copyOf, listAt } from './plain'
import type { Read } from './reading'
import { setValue } from './setting'

/** A copy right after it. */
export function duplicateItem(read: Read, path: Path): Patch {
  const from = path.slice(0, -1)
  const at = path.at(-1)
  const list = listPlaceAt(read, from)
  if (typeof at !== 'number' || !list?.place.items[at]) return refused('there is no such step')
  const data = copyOf(read.data)
  const select = [...from, at + 1]
  listAt(data, from)?.splice(at + 1, 0, copyOf(valueAt(read.data, path)))
  const changes = copying(read, list, at)
  if (!changes) return refused(COMPACT)
  const copied = land(read, changes, { data, select })
  const named = after(copied, (now) => withNewIds(now, select))
  return named.ok ? { ...named, select } : named
}

function copying(read: Read, list: ListPlace, at: number): Change[] | null {
  const { text } = read
  const item = list.place.items[at]
  if (!item) return null
  if (list.place.flow) return [{ from: item.end, to: item.end, insert: `, ${text.slice(item.start, item.end)}` }]
  const chunk = chunkOf(text, list.place, at)
  if (!chunk) return null
  const body = text.slice(lineStart(text, item.start), chunk.to)
  const next = chunkOf(text, list.place, at + 1)
  const gap = next ? text.slice(chunk.to, next.from) : '\n'
  return [{ from: chunk.to, to: chunk.to, insert: (gap.includes('#') ? '\n' : gap) + body }]
}

function withNewIds(read: Read, path: Path): Patch {
  const copy = valueAt(read.data, path)
  const taken = new Set<string>()
  gatherIds(read.data, taken)
  const ids = new Set<string>()
  gatherIds(copy, ids)
  const names = new Map<string, string>()
  for (const id of ids) {
    let number = 2
    const stem = id.replace(/_\d+$/, '')
    while (taken.has(`${stem}_${String(number)}`)) number++
    names.set(id, `${stem}_${String(number)}`)
    taken.add(`${stem}_${String(number)}`)
  }
  return names.size === 0 ? land(read, [], { data: read.data, select: path }) : setValue(read, path, renamed(copy, names))
}

export function gatherIds(data: unknown, into: Set<string>): void {
  if (typeof data !== 'object' || data === null) return
  if (!Array.isArray(data) && 'id' in data && typeof data.id === 'string') into.add(data.id)
  for (const inner of Object.values(data)) gatherIds(inner, into)
}

function renamed(data: unknown, names: ReadonlyMap<string, string>, key?: string): unknown {
  if (typeof data === 'string') {
    if (key === 'id') return names.get(data) ?? data
    if (!data.includes('${{')) return data
    return data.replace(/\bsteps\.([A-Za-z]\w*)/g, (whole, id: string) => (names.has(id) ? `steps.${names.get(id) ?? id}` : whole))
  }
  if (Array.isArray(data)) return data.map((item: unknown) => renamed(item, names))
  if (typeof data !== 'object' || data === null) return data
  return Object.fromEntries(Object.entries(data).map(([name, value]) => [name, renamed(value, names, name)]))
}
