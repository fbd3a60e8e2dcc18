// A change is applied only if the text, read again, means exactly what was intended and lost no comment.
import { ChangeSet } from '@codemirror/state'
import { isMap, type Path } from './path'
import { commentsOf, read, type Read } from './reading'

export interface Change {
  from: number
  to: number
  insert: string
}

/** `select` is the place that the change was about, in the text as it is then. */
export type Patch =
  | { ok: true; changes: Change[]; text: string; select: Path }
  | { ok: false; reason: string }

export function refused(reason: string): Patch {
  return { ok: false, reason }
}

export interface Intent {
  data: unknown
  select: Path
  /** Only what removes may lose comments. */
  mayLose?: boolean
}

/** The changes as a patch, or why they would not do what was intended. */
export function land(before: Read, changes: readonly Change[], intent: Intent): Patch {
  let text: string
  let set: ChangeSet
  try {
    set = ChangeSet.of([...changes], before.text.length)
    text = apply(before.text, set)
  } catch {
    return refused('the places to change overlap: edit this in YAML')
  }
  const after = read(text)
  if (!after.ok) return refused(`the text would no longer be YAML (${after.message}): edit this in YAML`)
  if (!sameData(after.data, intent.data)) return refused('the text would not mean what was intended: edit this in YAML')
  if (!intent.mayLose && lostComment(before.text, text)) return refused('a comment would be lost: edit this in YAML')
  return { ok: true, changes: listed(set), text, select: intent.select }
}

/** One patch after the other, as one; the second applies to the result of the first. */
export function after(first: Patch, next: (read: Read) => Patch): Patch {
  if (!first.ok) return first
  const between = read(first.text)
  if (!between.ok) return refused(between.message)
  const second = next(between)
  if (!second.ok) return second
  const length = first.text.length
  const grown = first.changes.reduce((sum, one) => sum + one.insert.length - (one.to - one.from), 0)
  const whole = ChangeSet.of(first.changes, length - grown).compose(ChangeSet.of(second.changes, length))
  return { ...second, changes: listed(whole) }
}

function apply(text: string, set: ChangeSet): string {
  let out = ''
  let at = 0
  set.iterChanges((from, to, _fromB, _toB, insert) => {
    out += text.slice(at, from) + insert.sliceString(0, undefined, '\n')
    at = to
  }, true)
  return out + text.slice(at)
}

function listed(set: ChangeSet): Change[] {
  const changes: Change[] = []
  set.iterChanges((from, to, _fromB, _toB, insert) => changes.push({ from, to, insert: insert.sliceString(0, undefined, '\n') }), true)
  return changes
}

function lostComment(before: string, after: string): boolean {
  if (!before.includes('#')) return false
  const counts = new Map<string, number>()
  for (const { text } of commentsOf(after)) counts.set(text, (counts.get(text) ?? 0) + 1)
  return commentsOf(before).some(({ text }) => {
    const left = (counts.get(text) ?? 0) - 1
    counts.set(text, left)
    return left < 0
  })
}

/** Equal values; the order of keys does not matter. */
export function sameData(a: unknown, b: unknown): boolean {
  if (Array.isArray(a) && Array.isArray(b)) return a.length === b.length && a.every((item, i) => sameData(item, (b as unknown[])[i]))
  if (isMap(a) && isMap(b)) {
    const keys = Object.keys(a)
    return keys.length === Object.keys(b).length && keys.every((key) => Object.hasOwn(b, key) && sameData(a[key], b[key]))
  }
  return Object.is(a, b) || (a == null && b == null)
}
