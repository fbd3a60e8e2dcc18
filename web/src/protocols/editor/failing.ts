// What happens if a step fails for good: read from the protocol as one of five words, and written as it has them.
import type { Edit } from '../text/edit'
import { isMap, valueAt, type Path } from '../text/path'
import { kindOf } from '../text/steps'
import { LOOPS } from './stepFields'

/** Left out: the iteration, by the `keep_going` of the loop around the step. */
export type Fate = 'stop' | 'leave' | 'continue' | 'ask' | 'pause'

const FIRST_HOLES = 5

/** The loop whose iteration ends if the step fails; null if there is none. */
export function loopAround(data: unknown, path: Path): Path | null {
  for (let length = path.length - 2; length > 1; length--) {
    const kind = kindOf(valueAt(data, path.slice(0, length)))
    if (kind !== null && LOOPS.has(kind) && path[length] === 'steps' && typeof path[length - 1] === 'number') return path.slice(0, length)
  }
  return null
}

function asked(step: Record<string, unknown>): number {
  const list = Array.isArray(step['fallback']) ? (step['fallback'] as unknown[]) : []
  return kindOf(list.at(-1)) === 'ask' ? list.length - 1 : -1
}

/** Other ways that are tried before, without the question at their end. */
export function waysOf(step: Record<string, unknown>): number {
  const list = Array.isArray(step['fallback']) ? step['fallback'].length : 0
  return asked(step) >= 0 ? list - 1 : list
}

export function fateOf(data: unknown, path: Path): Fate {
  const step = valueAt(data, path)
  if (!isMap(step)) return 'stop'
  if (asked(step) >= 0) return 'ask'
  if (step['on_error'] === 'continue' || step['on_error'] === 'pause') return step['on_error']
  const loop = loopAround(data, path)
  const holes = loop && valueAt(data, [...loop, 'keep_going'])
  return holes == null || holes === false ? 'stop' : 'leave'
}

/** The edits that make it so; the other words are taken back. */
export function failingAs(data: unknown, path: Path, fate: Fate): Edit[] {
  const step = valueAt(data, path)
  if (!isMap(step) || fate === fateOf(data, path)) return []
  const edits: Edit[] = []
  const question = asked(step)
  const loop = loopAround(data, path)
  if (question === 0 && fate !== 'ask') edits.push({ kind: 'drop', path: [...path, 'fallback'] })
  else if (question > 0 && fate !== 'ask') edits.push({ kind: 'remove', path: [...path, 'fallback', question] })
  if (fate === 'continue' || fate === 'pause') edits.push({ kind: 'set', path: [...path, 'on_error'], value: fate })
  else if (step['on_error'] !== undefined) edits.push({ kind: 'drop', path: [...path, 'on_error'] })
  if (fate === 'ask') edits.push({ kind: 'wrap', path, wrap: 'fallback' })
  if (loop && fate === 'leave' && !holds(data, loop)) edits.push({ kind: 'set', path: [...loop, 'keep_going'], value: { max_failed: FIRST_HOLES } })
  if (loop && fate === 'stop' && holds(data, loop)) edits.push({ kind: 'drop', path: [...loop, 'keep_going'] })
  return edits
}

function holds(data: unknown, loop: Path): boolean {
  const holes = valueAt(data, [...loop, 'keep_going'])
  return holes !== undefined && holes !== null && holes !== false
}
