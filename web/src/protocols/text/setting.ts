// Set, add, remove and rename single values with the smallest change of the text.
import { intoFlow, outOfFlow } from './flow'
import { after, land, refused, sameData, type Change, type Patch } from './land'
import { columnOf, lineEnd, lineStart, beginsLine, tailEnd } from './lines'
import { insertItems, removeItem } from './listing'
import { child, isMap, valueAt, type Path } from './path'
import { itemAt, placeAt, type Item, type Place } from './place'
import { withValue, without } from './plain'
import type { Read } from './reading'
import { placeOfKey } from './steps'
import { isPlain, writeFlow, writeKey, writeScalar, writeValue } from './write'

/** Replace a value, or add a new key to a map. Maps and lists change part by part. */
export function setValue(read: Read, path: Path, value: unknown): Patch {
  const before = valueAt(read.data, path)
  const part = path.at(-1)
  if (part === undefined) return refused('the whole protocol is edited in YAML')
  const parent = placeAt(read.root, path.slice(0, -1))
  const item = itemAt(parent, part)
  if (!item) return typeof part === 'number' ? refused('there is no such item') : addPair(read, path, value)
  if (sameData(before, value)) return land(read, [], { data: read.data, select: path })
  if (isMap(before) && isMap(value) && item.value.kind === 'map' && item.value.items.length > 0) return setMembers(read, path, before, value)
  if (Array.isArray(before) && Array.isArray(value) && item.value.kind === 'list' && value.length > 0 && before.length > 0) {
    return setItems(read, path, before as unknown[], value as unknown[])
  }
  const data = withValue(read.data, path, value)
  return land(read, replacing(read, item, before, value, parent), { data, select: path })
}

function replacing(read: Read, item: Item, before: unknown, value: unknown, parent: Place | undefined): Change[] {
  const { text, json } = read
  const old = item.value
  const flow = parent?.flow === true
  const simple = !isMap(value) && !Array.isArray(value)
  // Unnecessary quotes were intended; those that an expression needed go with it.
  const quote = typeof before === 'string' && isPlain(before, flow) ? old.quote : 'plain'
  const written = simple ? writeScalar(value, { flow, json, quote }) : writeFlow(value, json)
  if (old.kind === 'empty') return [{ from: item.mark, to: item.mark, insert: ` ${written}` }]
  const inBlock = (old.kind === 'map' || old.kind === 'list') && !old.flow
  if (inBlock && lineStart(text, old.from) > item.mark) {
    const head = lineEnd(text, item.mark)
    return [{ from: item.mark, to: item.mark, insert: ` ${written}` }, { from: head, to: old.to, insert: '' }]
  }
  if (!simple && !flow && !json && item.key !== null) {
    const block = writeValue(value, columnOf(text, item.start), json)
    if (block.startsWith('\n')) return [{ from: item.mark, to: old.to, insert: block }]
  }
  return [{ from: old.from, to: old.to, insert: written }]
}

/** Members that differ, one after the other. */
function setMembers(read: Read, path: Path, before: Record<string, unknown>, value: Record<string, unknown>): Patch {
  let patch = land(read, [], { data: read.data, select: path })
  const wanted = Object.entries(value).filter(([, member]) => member !== undefined)
  for (const [key, member] of wanted) {
    if (Object.hasOwn(before, key) && sameData(before[key], member)) continue
    patch = after(patch, (now) => setValue(now, [...path, key], member))
  }
  for (const key of Object.keys(before)) {
    if (value[key] === undefined) patch = after(patch, (now) => removeKey(now, [...path, key]))
  }
  return patch.ok ? { ...patch, select: path } : patch
}

/** Items that differ, then extra or missing items at the end. */
function setItems(read: Read, path: Path, before: readonly unknown[], value: readonly unknown[]): Patch {
  let patch = land(read, [], { data: read.data, select: path })
  for (const [i, item] of value.slice(0, before.length).entries()) {
    if (!sameData(before[i], item)) patch = after(patch, (now) => setValue(now, [...path, i], item))
  }
  for (let i = before.length; i > value.length; i--) patch = after(patch, (now) => removeItem(now, [...path, i - 1]))
  const more = value.slice(before.length)
  if (more.length > 0) patch = after(patch, (now) => insertItems(now, path, before.length, more))
  return patch.ok ? { ...patch, select: path } : patch
}

function addPair(read: Read, path: Path, value: unknown): Patch {
  const { text, json } = read
  const key = String(path.at(-1))
  const parentPath = path.slice(0, -1)
  const map = placeAt(read.root, parentPath)
  const data = withValue(read.data, path, value)
  if (!map && typeof parentPath.at(-1) === 'string') return setValue(read, parentPath, { [key]: value })
  if (!map || map.kind === 'alias') return refused('there is no map to put this key into')
  if (map.kind === 'empty' || (map.kind === 'map' && map.items.length === 0 && !map.flow)) return setValue(read, parentPath, { [key]: value })
  if (map.kind !== 'map') return refused('there is no map to put this key into')
  const at = placeOfKey(parentPath, map.items.map((item) => item.key), key)
  const before = map.items[at - 1]
  if (map.flow) {
    const pair = `${writeKey(key, { flow: true, json })}: ${writeFlow(value, json)}`
    return land(read, [intoFlow(map, at, pair)], { data, select: path })
  }
  const first = map.items[0]
  if (!first) return refused('there is no map to put this key into')
  const column = columnOf(text, first.start)
  const pair = `${writeKey(key, { flow: false, json: false })}:${writeValue(value, column, false)}`
  const margin = '\n' + ' '.repeat(column)
  if (!before) return land(read, [{ from: first.start, to: first.start, insert: pair + margin }], { data, select: path })
  const end = tailEnd(text, before, column)
  const gap = column === 0 && pair.includes('\n') ? '\n' : ''
  return land(read, [{ from: end, to: end, insert: gap + margin + pair }], { data, select: path })
}

/** Remove a key and its value, with the comment on its line. */
export function removeKey(read: Read, path: Path): Patch {
  const part = path.at(-1)
  const map = placeAt(read.root, path.slice(0, -1))
  const index = map?.kind === 'map' ? map.items.findIndex((item) => item.key === String(part)) : -1
  const item = map?.items[index]
  if (!map || !item || child(valueAt(read.data, path.slice(0, -1)), String(part)) === undefined) return refused('there is no such key')
  const intent = { data: without(read.data, path), select: path.slice(0, -1), mayLose: true }
  return land(read, map.flow ? [outOfFlow(map, index)] : outOfBlock(read, path, map, index), intent)
}

function outOfBlock({ text, root }: Read, path: Path, map: Place, index: number): Change[] {
  const item = map.items[index]
  const next = map.items[index + 1]
  if (!item) return []
  const end = tailEnd(text, item, columnOf(text, item.start))
  if (!next && index === 0) {
    const owner = ownerOf(root, path)
    if (!owner) return [{ from: item.start, to: end, insert: '{}' }]
    const sameLine = !beginsLine(text, item.start)
    const from = sameLine ? item.start : lineEnd(text, lineStart(text, item.start) - 1)
    return [{ from: owner.mark, to: owner.mark, insert: ' {}' }, { from: sameLine ? owner.mark : from, to: end, insert: '' }]
  }
  if (beginsLine(text, item.start)) {
    const from = lineStart(text, item.start)
    return from > 0 && index > 0 ? [{ from: from - 1, to: end, insert: '' }] : [{ from, to: Math.min(end + 1, text.length), insert: '' }]
  }
  // The first key on a dash's line: what follows it moves up to the dash.
  const rest = text.slice(end, next?.start ?? end)
  return [{ from: item.start, to: rest.includes('#') ? end + rest.indexOf('#') : (next?.start ?? end), insert: '' }]
}

/** The item whose value contains the key at `path`; null for the protocol itself. */
function ownerOf(root: Place | null, path: Path): Item | null {
  const part = path.at(-2)
  return part === undefined ? null : (itemAt(placeAt(root, path.slice(0, -2)), part) ?? null)
}

/** Rename a key; references to it are not changed. */
export function renameKey(read: Read, path: Path, name: string): Patch {
  const parentPath = path.slice(0, -1)
  const parent = valueAt(read.data, parentPath)
  const item = itemAt(placeAt(read.root, parentPath), String(path.at(-1)))
  const map = placeAt(read.root, parentPath)
  if (!item || !isMap(parent) || !map) return refused('there is no such key')
  if (Object.hasOwn(parent, name)) return refused(`${name} already exists`)
  const renamed = Object.fromEntries(Object.entries(parent).map(([key, value]) => [key === path.at(-1) ? name : key, value]))
  const data = parentPath.length === 0 ? renamed : withValue(read.data, parentPath, renamed)
  const written = writeKey(name, { flow: map.flow, json: read.json })
  return land(read, [{ from: item.start, to: item.keyEnd, insert: written }], { data, select: [...parentPath, name] })
}
