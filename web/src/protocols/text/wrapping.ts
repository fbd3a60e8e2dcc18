// Put steps into a structure: at the same time, in order, for each ...
import { after, land, refused, type Change, type Intent, type Patch } from './land'
import { chunkOf, columnOf, lineEnd } from './lines'
import { COMPACT, insertItems, listPlaceAt } from './listing'
import { moveItem } from './moving'
import { isMap, valueAt, type Path } from './path'
import type { Place } from './place'
import { copyOf, listAt } from './plain'
import type { Read } from './reading'
import { setValue } from './setting'
import { kindOf } from './steps'
import { writeFlow, writePairs, writeScalar } from './write'

export const WRAPS = ['parallel', 'any', 'foreach', 'repeat', 'while', 'if', 'steps', 'fallback', 'finally'] as const
export type Wrap = (typeof WRAPS)[number]

/** The keys of a structure beside its steps, as placeholders, and the key of its steps. */
const HEADS: Record<Exclude<Wrap, 'fallback' | 'finally'>, { head: Record<string, unknown>; list: string }> = {
  parallel: { head: {}, list: 'parallel' },
  any: { head: {}, list: 'any' },
  foreach: { head: { foreach: { item: [1, 2, 3] } }, list: 'steps' },
  repeat: { head: { repeat: 2 }, list: 'steps' },
  while: { head: { while: '${{ false }}', max: 10 }, list: 'steps' },
  if: { head: { if: '${{ true }}' }, list: 'then' },
  steps: { head: {}, list: 'steps' },
}

/** What to do if the first way fails and no other is given. */
export function askWhatNow(name: string): Record<string, unknown> {
  return { ask: `${name} did not work. What now?`, choices: ['repeat', 'skip', 'stop'] }
}

/** Wrap the steps `path` and the `more` ones after it. */
export function wrapIn(read: Read, path: Path, wrap: Wrap, more = 0): Patch {
  const at = path.at(-1)
  const from = path.slice(0, -1)
  if (typeof at !== 'number' || !isMap(valueAt(read.data, path))) return refused('only a step can be put into a structure')
  if (wrap === 'finally') return intoFinally(read, path)
  if (wrap === 'fallback') return withFallback(read, path, more)
  const list = listPlaceAt(read, from)
  if (!list?.place.items[at + more]) return refused('there is no such step')
  const { head, list: key } = HEADS[wrap]
  const data = copyOf(read.data)
  const items = listAt(data, from)
  const inner = items?.splice(at, more + 1)
  items?.splice(at, 0, { ...copyOf(head), [key]: inner })
  const intent = { data, select: path }
  return list.place.flow ? wrapFlow(read, list.place, at, more, head, key, intent) : wrapLines(read, list.place, at, more, head, key, intent)
}

function wrapFlow(read: Read, list: Place, at: number, more: number, head: Record<string, unknown>, key: string, intent: Intent): Patch {
  const [first, last] = [list.items[at], list.items[at + more]]
  if (!first || !last) return refused('there is no such step')
  const said = Object.entries(head).map(([name, value]) => `${writeScalar(name, { flow: true, json: read.json })}: ${writeFlow(value, read.json)}, `)
  const opening = `{${said.join('')}${writeScalar(key, { flow: true, json: read.json })}: [`
  return land(read, [{ from: first.start, to: first.start, insert: opening }, { from: last.end, to: last.end, insert: ']}' }], intent)
}

/** A line for the head, and every line of the steps four columns to the right. */
function wrapLines(read: Read, list: Place, at: number, more: number, head: Record<string, unknown>, key: string, intent: Intent): Patch {
  const { text } = read
  const first = chunkOf(text, list, at)
  const last = chunkOf(text, list, at + more)
  if (!first || !last) return refused(COMPACT)
  const column = columnOf(text, list.items[at]?.start ?? 0)
  const margin = ' '.repeat(column)
  const said = Object.keys(head).length > 0 ? `${writePairs(head, column + 2)}\n${margin}  ` : ''
  const changes: Change[] = [{ from: first.from, to: first.from, insert: `${margin}- ${said}${key}:\n` }]
  for (let line = first.from; line < last.to; line = lineEnd(text, line) + 1) {
    if (text.slice(line, lineEnd(text, line)).trim() !== '') changes.push({ from: line, to: line, insert: '    ' })
  }
  return land(read, changes, intent)
}

/** Always at the end: to the end of `finally`. */
function intoFinally(read: Read, path: Path): Patch {
  const list = valueAt(read.data, ['finally'])
  if (path[0] === 'finally') return refused('this step already runs at the end')
  return moveItem(read, path, ['finally'], Array.isArray(list) ? list.length : 0)
}

/** Try in order: the steps after it are tried if it fails; without any, a person is asked. */
function withFallback(read: Read, path: Path, more: number): Patch {
  const step = valueAt(read.data, path)
  const at = Number(path.at(-1))
  const list = [...path, 'fallback']
  if (!isMap(step)) return refused('only a step can be tried in order')
  const there = Array.isArray(step['fallback']) ? step['fallback'].length : 0
  if (more === 0) {
    const name = typeof step['name'] === 'string' ? step['name'] : typeof step['id'] === 'string' ? step['id'] : (kindOf(step) ?? 'The step')
    const alternative = askWhatNow(name.charAt(0).toUpperCase() + name.slice(1))
    const added = there > 0 ? insertItems(read, list, there, [alternative]) : setValue(read, list, [alternative])
    return added.ok ? { ...added, select: path } : added
  }
  const next = [...path.slice(0, -1), at + 1]
  let patch = moveItem(read, next, list, there)
  for (let i = 1; i < more; i++) patch = after(patch, (now) => moveItem(now, next, list, there + i))
  return patch.ok ? { ...patch, select: path } : patch
}
