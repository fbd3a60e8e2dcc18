// A note is the comment lines directly above a step.
import { land, refused, type Patch } from './land'
import { chunkOf, columnOf, lineStart } from './lines'
import { COMPACT, listPlaceAt } from './listing'
import type { Path } from './path'
import type { Read } from './reading'

/** The lines without their `#`. */
export function noteOf(read: Read, path: Path): string | null {
  const span = noteSpan(read, path)
  if (!span) return null
  const lines = read.text.slice(span.from, span.to).split('\n').slice(0, -1)
  return lines.map((line) => line.trim().replace(/^# ?/, '')).join('\n')
}

export function setNote(read: Read, path: Path, note: string): Patch {
  const span = noteSpan(read, path)
  if (!span) return refused(COMPACT)
  const margin = ' '.repeat(span.column)
  const lines = note.trim() === '' ? [] : note.trim().split('\n').map((line) => `${margin}# ${line.trim()}`.trimEnd())
  const insert = lines.map((line) => `${line}\n`).join('')
  return land(read, [{ from: span.from, to: span.to, insert }], { data: read.data, select: path, mayLose: true })
}

function noteSpan({ text, ...rest }: Read, path: Path): { from: number; to: number; column: number } | null {
  const at = path.at(-1)
  const list = typeof at === 'number' ? listPlaceAt({ text, ...rest }, path.slice(0, -1)) : null
  const item = typeof at === 'number' ? list?.place.items[at] : undefined
  const chunk = list && item && typeof at === 'number' ? chunkOf(text, list.place, at) : null
  return chunk && item ? { from: chunk.from, to: lineStart(text, item.start), column: columnOf(text, item.start) } : null
}
