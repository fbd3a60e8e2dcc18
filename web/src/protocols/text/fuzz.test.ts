// Random visual edits over every shipped protocol: FUZZ=20000 npx vitest run src/protocols/text/fuzz
import { ChangeSet, Text } from '@codemirror/state'
import { readdirSync, readFileSync } from 'node:fs'
import { join } from 'node:path'
import { expect, test } from 'vitest'
import { parse } from 'yaml'
import { patch, type Edit } from './edit'
import { randomEdit, seeded } from './fuzz'
import { sameData } from './land'
import { meant } from './meant'
import { commentsOf, read } from './reading'
import { OPTIONAL_LISTS } from './steps'

const FOLDER = join(import.meta.dirname, '../../../../protocols')
const EDITS = Number(process.env['FUZZ'] ?? 600)
const IN_A_ROW = 12

const texts = [FOLDER, join(FOLDER, 'templates')].flatMap((folder) =>
  readdirSync(folder)
    .filter((name) => /\.(yaml|json)$/.test(name))
    .map((name) => ({ name, text: readFileSync(join(folder, name), 'utf8') })),
)

/** Ids and questions are made up by the edit, and an empty list stays where a comment needs it: they are not judged. */
function plain(data: unknown, edit: Edit): unknown {
  const moves = edit.kind === 'move' || edit.kind === 'wrap'
  const words = JSON.stringify(data, (key: string, value: unknown) => {
    if (moves && OPTIONAL_LISTS.has(key) && Array.isArray(value) && value.length === 0) return undefined
    if (edit.kind === 'duplicate' && (key === 'id' || (typeof value === 'string' && value.includes('steps.')))) return '?'
    return edit.kind === 'wrap' && key === 'ask' ? '?' : value
  })
  return JSON.parse(words)
}

/** What removes may lose comments; so may a map or list that is set to another. */
function mayLose(edit: Edit): boolean {
  return ['remove', 'drop', 'note'].includes(edit.kind) || (edit.kind === 'set' && typeof edit.value === 'object' && edit.value !== null)
}

function counted(text: string): Map<string, number> {
  const counts = new Map<string, number>()
  for (const comment of commentsOf(text)) counts.set(comment.text, (counts.get(comment.text) ?? 0) + 1)
  return counts
}

test(`${String(EDITS)} random edits mean what was intended, lose no comment, and undo to the same bytes`, () => {
  const random = seeded(2026)
  const done: Record<string, [number, number]> = {}
  const reasons: Record<string, number> = {}
  for (let n = 0; n < EDITS; ) {
    for (const { name, text: original } of texts) {
      let text = original
      const undo: ChangeSet[] = []
      for (let i = 0; i < IN_A_ROW && n < EDITS; i++, n++) {
        const before = parse(text, { merge: true }) as unknown
        const edit = randomEdit(random, before)
        const result = patch(text, edit)
        const counts = (done[edit.kind] ??= [0, 0])
        counts[result.ok ? 0 : 1]++
        if (!result.ok) {
          reasons[result.reason.slice(0, 60)] = (reasons[result.reason.slice(0, 60)] ?? 0) + 1
          continue
        }
        const told = `${name}: ${JSON.stringify(edit)}\n--- before\n${text}\n--- after\n${result.text}`
        const doc = Text.of(text.split('\n'))
        const changes = ChangeSet.of(result.changes, doc.length)
        expect(changes.apply(doc).toString(), told).toBe(result.text)
        undo.push(changes.invert(doc))
        expect(sameData(plain(parse(result.text, { merge: true }), edit), plain(meant(before, edit), edit)), told).toBe(true)
        if (!mayLose(edit)) {
          const left = counted(result.text)
          for (const [comment, count] of counted(text)) expect(left.get(comment) ?? 0, `${comment} in ${told}`).toBeGreaterThanOrEqual(count)
        }
        text = result.text
      }
      let doc = Text.of(text.split('\n'))
      for (const changes of undo.reverse()) doc = changes.apply(doc)
      expect(doc.toString()).toBe(original)
    }
  }
  if (process.env['FUZZ']) process.stdout.write(`${JSON.stringify({ done, reasons }, null, 1)}\n`)
  const landed = Object.values(done).reduce((sum, [ok]) => sum + ok, 0)

  expect(landed).toBeGreaterThan(EDITS * 0.6)
}, 3_600_000)

test('every shipped protocol is read', () => {
  const broken = texts.filter(({ text }) => !read(text).ok).map(({ name }) => name)

  expect(broken).toEqual([])
})
