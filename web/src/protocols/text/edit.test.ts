// What visual edits do to a text: the smallest change, comments kept, and refusals with a reason.
import { describe, expect, test } from 'vitest'
import { patch, patchAll, type Edit } from './edit'
import { read } from './reading'

const TEXT = `# a map
labrun: 1
name: map

steps:
  # before all
  - id: lift                # up
    do: gantry.move_to
    with: {z: 5 mm}

  - {id: shoot, do: libs.measure, retry: 3}   # fires
  - id: both
    parallel:               # together
      - {do: gantry.home}
      - do: libs.locate
        timeout: 10 s

finally:                    # in any case
  - {do: libs.disarm}
`

function after(edit: Edit, text = TEXT): string {
  const done = patch(text, edit)
  return done.ok ? done.text : `refused: ${done.reason}`
}

describe('a value', () => {
  test('is replaced in place, and nothing else', () => {
    const done = patch(TEXT, { kind: 'set', path: ['steps', 0, 'with', 'z'], value: '7 mm' })

    expect(done.ok && done.changes).toEqual([{ from: TEXT.indexOf('5 mm'), to: TEXT.indexOf('5 mm') + 4, insert: '7 mm' }])
  })

  test('that is set to what it is changes nothing', () => {
    const done = patch(TEXT, { kind: 'set', path: ['steps', 1, 'retry'], value: 3 })

    expect(done.ok && done.changes).toEqual([])
  })

  test('gets quotes if YAML would read something else', () => {
    const set = (value: unknown) => after({ kind: 'set', path: ['name'], value })

    expect(set('yes')).toContain('name: "yes"')
    expect(set('1:30')).toContain('name: "1:30"')
    expect(set('a: b')).toContain('name: "a: b"')
    expect(set('two words')).toContain('name: two words')
  })

  test('that is an expression is quoted between brackets, and loses the quotes with the expression', () => {
    const formula = after({ kind: 'set', path: ['steps', 0, 'with', 'z'], value: '${{ params.z }}' })

    expect(formula).toContain('with: {z: "${{ params.z }}"}')
    expect(after({ kind: 'set', path: ['steps', 0, 'with', 'z'], value: '5 mm' }, formula)).toBe(TEXT)
  })

  test('under a new key goes where the language puts it', () => {
    expect(after({ kind: 'set', path: ['steps', 0, 'name'], value: 'Lift it' })).toContain('- id: lift                # up\n    name: Lift it\n    do: gantry.move_to')
    expect(after({ kind: 'set', path: ['steps', 1, 'timeout'], value: '9 s' })).toContain('{id: shoot, do: libs.measure, timeout: 9 s, retry: 3}   # fires')
    expect(after({ kind: 'set', path: ['params'], value: { x: { type: 'integer' } } })).toMatch(/name: map\n\s*params:/)
  })

  test('that is shared by an alias is refused where it would change elsewhere', () => {
    const text = 'labrun: 1\nname: a\nsteps:\n  - {log: &word hello}\n  - {log: *word}\n'

    expect(after({ kind: 'set', path: ['steps', 0, 'log'], value: 'bye' }, text)).toContain('refused: the text would not mean what was intended')
  })
})

describe('a step', () => {
  test('moves with its comments', () => {
    const moved = after({ kind: 'move', path: ['steps', 0], to: ['steps'], index: 2 })

    expect(moved).toContain('steps:\n  - {id: shoot, do: libs.measure, retry: 3}   # fires\n\n  # before all\n  - id: lift                # up')
  })

  test('moves into another list at its indentation', () => {
    const moved = after({ kind: 'move', path: ['steps', 0], to: ['steps', 2, 'parallel'], index: 1 })

    expect(moved).toContain('      - {do: gantry.home}\n      # before all\n      - id: lift                # up\n        do: gantry.move_to\n        with: {z: 5 mm}\n      - do: libs.locate')
  })

  test('cannot move into itself', () => {
    expect(after({ kind: 'move', path: ['steps', 2], to: ['steps', 2, 'parallel'], index: 0 })).toBe('refused: a step cannot be moved into itself')
  })

  test('that leaves an optional list empty removes its key, unless a comment is there', () => {
    const text = TEXT.replace('finally:                    # in any case', 'finally:')

    expect(after({ kind: 'move', path: ['finally', 0], to: ['steps'], index: 0 }, text)).not.toContain('finally')
    expect(after({ kind: 'move', path: ['finally', 0], to: ['steps'], index: 0 })).toContain('finally: []                    # in any case')
  })

  test('goes into finally', () => {
    const ended = after({ kind: 'wrap', path: ['steps', 1], wrap: 'finally' })

    expect(ended).toContain('finally:                    # in any case\n  - {do: libs.disarm}\n  - {id: shoot, do: libs.measure, retry: 3}   # fires')
  })

  test('is copied with new ids, and what refers to them follows', () => {
    const text = 'labrun: 1\nname: a\nsteps:\n  - id: loop\n    repeat: 2\n    steps:\n      - {id: go, do: a.b}\n      - log: ${{ steps.go.x }}\n'
    const copied = after({ kind: 'duplicate', path: ['steps', 0] }, text)

    expect(copied).toContain('  - id: loop_2\n    repeat: 2\n    steps:\n      - {id: go_2, do: a.b}\n      - log: ${{ steps.go_2.x }}\n')
  })

  test('is wrapped, with those after it, and unwrapped to the same bytes', () => {
    const wrapped = after({ kind: 'wrap', path: ['steps', 0], wrap: 'parallel', more: 1 })

    expect(wrapped).toContain('  - parallel:\n      # before all\n      - id: lift                # up\n        do: gantry.move_to')
    expect(after({ kind: 'unwrap', path: ['steps', 0] }, wrapped)).toBe(TEXT)
  })

  test('that is unwrapped keeps the comments of what held it', () => {
    expect(after({ kind: 'unwrap', path: ['steps', 2] })).toContain('  # together\n  - {do: gantry.home}\n  - do: libs.locate\n    timeout: 10 s\n')
  })

  test('tried in order asks a person if nothing else is given', () => {
    expect(after({ kind: 'wrap', path: ['steps', 1], wrap: 'fallback' })).toContain('fallback: [{ask: Shoot did not work. What now?, choices: [repeat, skip, stop]}]}   # fires')
  })

  test('gets a note as a comment above it', () => {
    const noted = after({ kind: 'note', path: ['steps', 1], note: 'one\ntwo' })

    expect(noted).toContain('\n  # one\n  # two\n  - {id: shoot')
    expect(after({ kind: 'note', path: ['steps', 1], note: '' }, noted)).toBe(TEXT)
  })

  test('put into an empty list makes it a list of lines', () => {
    const text = 'labrun: 1\nname: a\nsteps: []   # none yet\n'

    expect(after({ kind: 'insert', path: ['steps'], index: 0, values: [{ wait: '1 s' }] }, text)).toBe('labrun: 1\nname: a\nsteps:   # none yet\n  - wait: 1 s\n')
  })
})

describe('what cannot be done', () => {
  test('in a broken text is reported with its line', () => {
    expect(after({ kind: 'remove', path: ['steps', 0] }, `${TEXT}oops: [`)).toMatch(/^refused: the text has an error on line \d+/)
  })

  test('several edits are one, or none', () => {
    const both = patchAll(TEXT, [{ kind: 'set', path: ['devices', 'libs'], value: 'libs_analyzer@1' }, { kind: 'insert', path: ['steps'], index: 3, values: [{ do: 'libs.measure' }] }])
    const none = patchAll(TEXT, [{ kind: 'set', path: ['name'], value: 'x' }, { kind: 'remove', path: ['steps', 99] }])

    expect(both.ok && both.text).toContain('devices:')
    expect(both.ok && both.text).toMatch(/timeout: 10 s\n {2}- do: libs\.measure\n/)
    expect(none.ok).toBe(false)
  })

  test('JSON stays JSON', () => {
    const text = '{"labrun": 1, "name": "a", "steps": [{"wait": "1 s"}]}'
    const added = after({ kind: 'insert', path: ['steps'], index: 1, values: [{ do: 'a.b', with: { x: 1 } }] }, text)

    expect(JSON.parse(added)).toEqual({ labrun: 1, name: 'a', steps: [{ wait: '1 s' }, { do: 'a.b', with: { x: 1 } }] })
    expect(read(added).ok).toBe(true)
  })
})
