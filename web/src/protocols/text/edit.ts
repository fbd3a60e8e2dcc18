// The visual edits by name, and the one place that carries them out on a text.
import { duplicateItem } from './copying'
import { after, type Patch } from './land'
import { insertItems, removeItem } from './listing'
import { moveItem } from './moving'
import { setNote } from './noting'
import { valueAt, type Path } from './path'
import { read, type Read } from './reading'
import { removeKey, renameKey, setValue } from './setting'
import { unwrap } from './unwrapping'
import { wrapIn, type Wrap } from './wrapping'

export type Edit =
  | { kind: 'set'; path: Path; value: unknown }
  | { kind: 'drop'; path: Path }
  | { kind: 'rename'; path: Path; name: string }
  | { kind: 'insert'; path: Path; index: number; values: readonly unknown[] }
  | { kind: 'remove'; path: Path }
  | { kind: 'move'; path: Path; to: Path; index: number }
  | { kind: 'duplicate'; path: Path }
  | { kind: 'wrap'; path: Path; wrap: Wrap; more?: number }
  | { kind: 'unwrap'; path: Path }
  | { kind: 'note'; path: Path; note: string }

/** The text changes for an edit; `ok: false` says why it cannot be done visually. */
export function patch(text: string, edit: Edit): Patch {
  const now = read(text)
  if (!now.ok) return { ok: false, reason: `the text has an error on line ${String(now.line)}: fix it first` }
  try {
    return patched(now, edit)
  } catch (error) {
    if (error instanceof RangeError) return { ok: false, reason: error.message }
    throw error
  }
}

/** Several edits as one, each applied to the result of the one before; `select` is that of the last. */
export function patchAll(text: string, edits: readonly Edit[]): Patch {
  const [first, ...rest] = edits
  if (!first) return { ok: false, reason: 'there is nothing to do' }
  return rest.reduce((done, edit) => after(done, (now) => patch(now.text, edit)), patch(text, first))
}

/** A step after all others of `finally`. */
export function lastOfAll(data: unknown, step: Record<string, unknown>): Edit[] {
  const list = valueAt(data, ['finally'])
  if (Array.isArray(list)) return [{ kind: 'insert', path: ['finally'], index: list.length, values: [step] }]
  return [{ kind: 'set', path: ['finally'], value: [step] }]
}

function patched(now: Read, edit: Edit): Patch {
  switch (edit.kind) {
    case 'set': return setValue(now, edit.path, edit.value)
    case 'drop': return removeKey(now, edit.path)
    case 'rename': return renameKey(now, edit.path, edit.name)
    case 'insert': return insertItems(now, edit.path, edit.index, edit.values)
    case 'remove': return removeItem(now, edit.path)
    case 'move': return moveItem(now, edit.path, edit.to, edit.index)
    case 'duplicate': return duplicateItem(now, edit.path)
    case 'wrap': return wrapIn(now, edit.path, edit.wrap, edit.more)
    case 'unwrap': return unwrap(now, edit.path)
    case 'note': return setNote(now, edit.path, edit.note)
  }
}
