// The outline of a protocol: one row per step, in the order of the text, with its location.
import { isMap, type Path } from './path'
import { itemAt, type Item, type Place } from './place'
import type { Read } from './reading'
import { kindOf, SECTIONS, type StepKind } from './steps'
import { shown, wordsOf } from './titles'
import { innerKey } from './unwrapping'

export type RowKind = StepKind | 'about' | 'params' | 'devices' | 'section' | 'branch' | 'sequence' | 'odd'

export interface Row {
  path: Path
  kind: RowKind
  title: string
  detail: string
  id: string
  from: number
  to: number
  /** 1 is the outermost. */
  level: number
  /** The number of its parent row; -1 for none. */
  parent: number
  /** The number of the first row after all its descendants. */
  end: number
  position: number
  setSize: number
}

export function rowsOf({ data, root }: Read): Row[] {
  if (!isMap(data) || root?.kind !== 'map') return []
  const rows: Row[] = []
  const about = { ...blank([], 'about', itemAt(root, 'name') ?? { start: root.from, end: root.from }), title: shown(data['name']), detail: shown(data['summary'] ?? '') }
  rows.push({ ...about, end: 1 })
  for (const key of ['devices', 'params'] as const) addTable(rows, data, root, key)
  for (const key of SECTIONS) addSection(rows, data, root, key)
  const top = rows.filter((row) => row.level === 1)
  for (const [i, row] of top.entries()) Object.assign(row, { position: i + 1, setSize: top.length })
  return rows
}

function blank(path: Path, kind: RowKind, at: { start: number; end: number }, level = 1, parent = -1): Row {
  return { path, kind, title: '', detail: '', id: '', from: at.start, to: at.end, level, parent, end: 0, position: 1, setSize: 1 }
}

function addTable(rows: Row[], data: Record<string, unknown>, root: Place, key: 'params' | 'devices'): void {
  const item = itemAt(root, key)
  if (!item) return
  const names = Object.keys(isMap(data[key]) ? data[key] : {})
  const title = key === 'params' ? 'Parameters' : 'Devices'
  rows.push({ ...blank([key], key, item), title, detail: names.join(', '), end: rows.length + 1 })
}

/** The steps themselves are at the top level; on_resume and finally have their own rows. */
function addSection(rows: Row[], data: Record<string, unknown>, root: Place, key: (typeof SECTIONS)[number]): void {
  const item = itemAt(root, key)
  if (!item) return
  if (key === 'steps') {
    addList(rows, data[key], item.value, [key], 1, -1)
    return
  }
  const title = key === 'finally' ? 'Always at the end' : 'When a run is resumed'
  branch(rows, data[key], item, [key], 'section', title, 1, -1)
}

function branch(rows: Row[], list: unknown, item: Item, path: Path, kind: RowKind, title: string, level: number, parent: number): void {
  const number = rows.length
  const row = { ...blank(path, kind, item, level, parent), title }
  rows.push(row)
  addList(rows, list, item.value, path, level + 1, number)
  row.end = rows.length
}

function addList(rows: Row[], list: unknown, place: Place, path: Path, level: number, parent: number): void {
  if (!Array.isArray(list) || place.kind !== 'list') return
  for (const [i, step] of (list as unknown[]).entries()) {
    const item = place.items[i]
    if (!item) continue
    const row = addStep(rows, step, item, [...path, i], level, parent)
    row.position = i + 1
    row.setSize = list.length
  }
}

function addStep(rows: Row[], step: unknown, item: Item, path: Path, level: number, parent: number): Row {
  const kind = kindOf(step)
  const number = rows.length
  const row: Row = { ...blank(path, kind ?? (Array.isArray(step) ? 'sequence' : 'odd'), item, level, parent), ...wordsOf(step) }
  if (isMap(step) && typeof step['id'] === 'string') row.id = step['id']
  rows.push(row)
  if (Array.isArray(step)) addList(rows, step, item.value, path, level + 1, number)
  if (isMap(step)) {
    const inner = innerKey(kind)
    const holder = inner === null ? undefined : itemAt(item.value, inner)
    if (inner !== null && holder) addList(rows, step[inner], holder.value, [...path, inner], level + 1, number)
    for (const [key, title] of [['else', 'Otherwise'], ['fallback', 'If it fails, try in order']] as const) {
      const other = itemAt(item.value, key)
      if (other && Array.isArray(step[key])) branch(rows, step[key], other, [...path, key], 'branch', title, level + 1, number)
    }
  }
  row.end = rows.length
  return row
}
