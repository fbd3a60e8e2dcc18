// What happens if a step fails: as it is read from the protocol, and as it is written.
import { expect, test } from 'vitest'
import { patchAll } from '../text/edit'
import { valueAt, type Path } from '../text/path'
import { read } from '../text/reading'
import { failingAs, fateOf, loopAround, waysOf, type Fate } from './failing'

const TEXT = `steps:
  - do: gantry.home            # first of all
  - foreach: {point: [1, 2]}
    steps:
      - do: gantry.home
        on_error: pause
      - parallel:
          - {do: gantry.home}
          - {do: libs.locate}
`
const INNER: Path = ['steps', 1, 'steps', 0]

function data(text: string): unknown {
  const now = read(text)
  if (!now.ok) throw new Error(now.message)
  return now.data
}
function become(text: string, path: Path, fate: Fate): string {
  const edits = failingAs(data(text), path, fate)
  if (edits.length === 0) return text
  const done = patchAll(text, edits)
  if (!done.ok) throw new Error(done.reason)
  return done.text
}

test('a step in a loop, and in a set in a loop, ends that loop’s iteration', () => {
  expect(loopAround(data(TEXT), INNER)).toEqual(['steps', 1])
  expect(loopAround(data(TEXT), ['steps', 1, 'steps', 1, 'parallel', 0])).toEqual(['steps', 1])
  expect(loopAround(data(TEXT), ['steps', 0])).toBe(null)
  expect(loopAround(data(TEXT), ['steps', 1])).toBe(null)
})

test('every word can follow every other, and is read as it was written', () => {
  const fates: Fate[] = ['stop', 'leave', 'continue', 'ask', 'pause']
  for (const first of fates) {
    for (const second of fates) {
      const text = become(become(TEXT, INNER, first), INNER, second)
      expect(fateOf(data(text), INNER), `${first}, ${second}\n${text}`).toBe(second)
      expect(text).toContain('# first of all')
    }
  }
})

test('what is left out is counted by the loop; what a person is asked comes after the other ways', () => {
  expect(become(TEXT, INNER, 'leave')).toContain('    keep_going: {max_failed: 5}\n    steps:\n      - do: gantry.home')
  const other = TEXT.replace('on_error: pause', 'fallback: [{do: gantry.unlock}]')
  const asked = become(other, INNER, 'ask')
  const step = valueAt(data(asked), INNER) as Record<string, unknown>

  expect(asked).toContain('choices: [repeat, skip, stop]')
  expect([waysOf(step), (step['fallback'] as unknown[]).length]).toEqual([1, 2])
  expect(become(asked, INNER, 'stop')).toBe(other)
})
