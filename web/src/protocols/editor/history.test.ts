// One undo for everything: 500 mixed edits, taken back and done again, byte for byte.
import { redo, undo } from '@codemirror/commands'
import type { EditorState, Transaction } from '@codemirror/state'
import { readFileSync } from 'node:fs'
import { join } from 'node:path'
import { expect, test } from 'vitest'
import { patchAll, type Edit } from '../text/edit'
import { pick, randomEdit, seeded, type Random } from '../text/fuzz'
import { isMap, valueAt, type Path } from '../text/path'
import { read } from '../text/reading'
import { rowsOf } from '../text/rows'
import { structureOffers } from './adding'
import { failingAs, type Fate } from './failing'
import { fresh, writtenLoop, type LoopKind } from './loops'
import { stateOf } from './view'

const FOLDER = join(import.meta.dirname, '../../../../protocols')
const LONG = 1_400
const FATES: readonly Fate[] = ['stop', 'leave', 'continue', 'ask', 'pause']
const KINDS: readonly LoopKind[] = ['grid', 'line', 'plate', 'list', 'table', 'values']

/** An edit as one of the forms makes it; null if there is nothing there that it could change. */
function formEdit(random: Random, text: string): readonly Edit[] | null {
  const now = read(text)
  if (!now.ok) return null
  const paths = rowsOf(now).map((row) => row.path).filter((path) => typeof path.at(-1) === 'number')
  if (paths.length === 0) return null
  const path: Path = pick(random, paths)
  const step = valueAt(now.data, path)
  const loop = isMap(step) && isMap(step['foreach']) ? Object.keys(step['foreach'])[0] : undefined
  if (loop !== undefined) return [{ kind: 'set', path: [...path, 'foreach', loop], value: writtenLoop(fresh(pick(random, KINDS))) }]
  if (random() < 0.3) return pick(random, structureOffers([], [])).edits(now.data, path, random() < 0.5)
  return failingAs(now.data, path, pick(random, FATES))
}

/** A protocol that only grows would be read ever more slowly. */
function shorter(random: Random, text: string): readonly Edit[] | null {
  const now = read(text)
  const rows = now.ok ? rowsOf(now).filter((row) => typeof row.path.at(-1) === 'number') : []
  return rows.length > 0 ? [{ kind: 'remove', path: pick(random, rows).path }] : null
}

/** What a person types: a comment, a letter that breaks the text, a line cut out. */
function typed(random: Random, state: EditorState): { from: number; to: number; insert: string } {
  const line = state.doc.line(1 + Math.floor(random() * state.doc.lines))
  if (random() < 0.6) return { from: line.to, to: line.to, insert: ' # typed' }
  if (random() < 0.5) return { from: line.from, to: line.from, insert: pick(random, ['[', '"', 'x', '\n']) }
  return { from: line.from, to: line.to, insert: '' }
}

for (const [name, edits] of [['hello.yaml', 500], ['weigh_and_dispense.json', 40]] as const) {
  test(`${String(edits)} mixed edits of ${name} are undone to its first byte and done again to the last`, () => {
    const random = seeded(21)
    const first = readFileSync(join(FOLDER, name), 'utf8')
    let state = stateOf(first, { save: () => undefined, fix: () => false }, [])
    const dispatch = (transaction: Transaction): void => void (state = transaction.state)
    let done = 0
    for (let tries = 0; done < edits && tries < 20 * edits; tries++) {
      const text = state.doc.toString()
      const now = read(text)
      const which = random()
      if (!now.ok || which < 0.12) {
        // A text that is broken is mended as a person would: by undoing what broke it.
        if (!now.ok) undo({ state, dispatch })
        else dispatch(state.update({ changes: typed(random, state), userEvent: 'input.type' }))
        done++
        continue
      }
      const wanted = text.length > LONG ? shorter(random, text) : which < 0.5 ? formEdit(random, text) : [randomEdit(random, now.data)]
      const patch = wanted === null || wanted.length === 0 ? null : patchAll(text, wanted)
      if (patch?.ok !== true || patch.changes.length === 0) continue
      dispatch(state.update({ changes: patch.changes, userEvent: 'visual.edit' }))
      expect(state.doc.toString()).toBe(patch.text)
      done++
    }
    const last = state.doc.toString()
    let steps = 0
    while (undo({ state, dispatch })) steps++

    expect(done).toBe(edits)
    expect(steps).toBeGreaterThan(edits / 2)
    expect(state.doc.toString()).toBe(first)

    while (redo({ state, dispatch })) steps--

    expect(steps).toBe(0)
    expect(state.doc.toString()).toBe(last)
  }, 60_000)
}
