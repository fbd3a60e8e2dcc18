// The small parts of the editor: fixes, fields, context of the caret, merging, moves, line breaks.
import { getIndentation, IndentContext } from '@codemirror/language'
import { Text } from '@codemirror/state'
import { EditorView } from '@codemirror/view'
import { describe, expect, test } from 'vitest'
import { withoutBreaks } from './breaks'
import { contextAt } from './context'
import { asText, asValue, fieldsOf } from './fields'
import { fixOf } from './fixes'
import { compare, merged } from './merge'
import { moveOf, placeAfter } from './moves'
import { fileOf } from './used'
import { stateOf } from './view'
import { lastOfAll } from '../text/edit'

describe('fixes come from the checker’s messages', () => {
  const fix = (message: string, text: string, hint = '') => fixOf(message, hint, text, 10)

  test('a misspelt word', () => {
    expect(fix('gantry.hmoe: gantry@1 has no action hmoe; did you mean home?', 'gantry.hmoe')).toEqual({ label: 'Use home', from: 17, to: 21, insert: 'home' })
    expect(fix("unknown key 'attempt'; did you mean attempts?", 'attempt')?.insert).toBe('attempts')
    expect(fix("steps.shot: no step has the id 'shot'; did you mean steps.shoot?", '${{ steps.shot.shot_id }}')).toMatchObject({ from: 20, to: 24, insert: 'shoot' })
  })

  test('a number outside its range', () => {
    expect(fix('gantry.move_to.z: 300 mm is outside z 0..100 mm', '300 mm')).toEqual({ label: 'Use 100 mm', from: 10, to: 16, insert: '100 mm' })
    expect(fix('gantry.move_to.z: -3 mm is outside z 0..100 mm', '-3')?.insert).toBe('0')
    expect(fix('gantry.move_to.z: 300 mm is outside z 0..100 mm', '${{ params.z }}')).toBe(null)
  })

  test('a dangerous device without an end is made safe at the end', () => {
    const hint = 'its safe state is disarm; write it yourself, too: `finally: [{do: libs.disarm, on_error: continue}]`'

    expect(fix('libs.measure is dangerous (laser), and no `finally` makes libs safe', 'libs.measure', hint)).toEqual({ label: 'Add libs.disarm at the end', from: 10, to: 10, insert: '', atEnd: 'libs.disarm' })
    expect(lastOfAll({ steps: [] }, { do: 'libs.disarm' })).toEqual([{ kind: 'set', path: ['finally'], value: [{ do: 'libs.disarm' }] }])
    expect(lastOfAll({ finally: [{ log: 'a' }] }, { do: 'libs.disarm' })).toEqual([{ kind: 'insert', path: ['finally'], index: 1, values: [{ do: 'libs.disarm' }] }])
  })

  test('what the hint says to write', () => {
    expect(fix('an expression without quotes between brackets', '${{ x }}', 'inside {...} or [...] an expression needs quotes: write "${{ x }}"')?.insert).toBe('"${{ x }}"')
    expect(fix('an expression without quotes between brackets', '${{ grid(x=span(0 mm, 4 mm, 1 mm)) }}', 'an expression needs quotes: write "${{ grid(x=span(0 mm..."')?.insert).toBe('"${{ grid(x=span(0 mm, 4 mm, 1 mm)) }}"')
    expect(fix('an expression without quotes between brackets', '${{ f("x") }}', `an expression needs quotes: write '\${{ f("x") }}'`)?.insert).toBe(`'\${{ f("x") }}'`)
    expect(fix('single quotes; JSON has only double quotes', "'", 'write "..."')).toBe(null)
  })
})

describe('fields', () => {
  const fields = fieldsOf({ type: 'object', required: ['b'], properties: { a: { type: 'number', unit: 'mm', minimum: 0, maximum: 730 }, b: { enum: ['x', 'y'] }, c: { type: 'object' } } })

  test('come from the contract, required ones first', () => {
    expect(fields.map((one) => [one.name, one.kind, one.about])).toEqual([['b', 'choice', ''], ['a', 'number', '0–730 mm'], ['c', 'fields', '']])
  })

  test('write a bare number with its unit, an expression as it is, and a list as a list', () => {
    expect(asValue('12', 'number', 'mm')).toBe('12 mm')
    expect(asValue('2 cm', 'number', 'mm')).toBe('2 cm')
    expect(['0,5', '-1,25 mm', ',5e3', '1,2,3', '0,5'].map((text, i) => asValue(text, i < 4 ? 'number' : 'text', 'mm'))).toEqual(['0.5 mm', '-1.25 mm', '.5e3 mm', '1,2,3', '0,5'])
    expect(asValue('${{ params.x }}', 'number', 'mm')).toBe('${{ params.x }}')
    expect(asValue('Li, K, 3', 'list')).toEqual(['Li', 'K', 3])
    expect(['{red: [0, 200]}', 'space', '{red: ['].map((text) => asValue(text, 'fields'))).toEqual([{ red: [0, 200] }, 'space', '{red: ['])
    expect(asValue('  ', 'text')).toBe(undefined)
    expect([asValue('true', 'truth'), asValue('false', 'truth')]).toEqual([true, false])
    expect(asText(['Li', 'K'])).toBe('Li, K')
    expect(['−5', '−2,5 um'].map((text) => asValue(text, 'number', 'mm'))).toEqual(['-5 mm', '-2.5 um'])
  })

  test.each([[['A', 'B, C', ' D ', 'say "x"', '', 3]], [['007', '1E5', '12345678901234567', 7, 0.5, -2]], [['7', '1e-3', '[x]']]])('a list is given back as it was: %j', (list) => {
    expect(asValue(asText(list), 'list')).toEqual(list)
  })

  test('what is typed into a list is one item between two commas; a name of digits is no number, and among texts none is', () => {
    expect(asValue('007, 1E5, 12345678901234567, 0.50, "a, b", "7"', 'list')).toEqual(['007', '1E5', '12345678901234567', 0.5, 'a, b', '7'])
    expect(asValue('1, 2', 'list', '', true)).toEqual(['1', '2'])
    expect(asText(['1', '2'], true)).toBe('1, 2')
  })
})

describe('the caret', () => {
  function at(marked: string) {
    const offset = marked.indexOf('|')
    return contextAt(Text.of(marked.replace('|', '').split('\n')), offset)
  }

  test('is at a value of a step, in a list in a loop', () => {
    const { path, key } = at('steps:\n  - log: a\n  - foreach: {i: 1}\n    steps:\n      - wait: 1 s\n      - do: gan|')

    expect([path, key]).toEqual([['steps', 1, 'steps', 1], 'do'])
  })

  test('is at a new key, and knows its neighbours', () => {
    const { path, key, siblings } = at('steps:\n  - do: gantry.home\n    |')

    expect([path, key, [...siblings]]).toEqual([['steps', 0], null, [['do', 'gantry.home']]])
  })

  test('is between brackets', () => {
    const flow = at('steps:\n  - {do: gantry.move_to, with: {x: 1, y|')

    expect([flow.path, flow.key]).toEqual([['steps', 0, 'with'], null])
    expect(at('steps:\n  - {do: ga|').key).toBe('do')
  })
})

describe('two people', () => {
  test('who changed different lines are merged', () => {
    const blocks = compare('a\nb\nc\nd', 'A\nb\nc\nd', 'a\nb\nc\nD\ne')

    expect(blocks.map((one) => one.kind)).toEqual(['mine', 'same', 'theirs'])
    expect(merged(blocks, new Map())).toBe('A\nb\nc\nD\ne')
  })

  test('who changed the same line are asked', () => {
    const blocks = compare('a\nb', 'a\nmine', 'a\ntheirs')

    expect(merged(blocks, new Map([[1, 'theirs']]))).toBe('a\ntheirs')
    expect(merged(blocks, new Map([[1, 'both']]))).toBe('a\ntheirs\nmine')
    expect(merged(blocks, new Map())).toBe('a\nmine')
  })

  test('without a known base are asked about every difference', () => {
    expect(compare(null, 'a\nb', 'a\nc').map((one) => one.kind)).toEqual(['same', 'conflict'])
  })
})

describe('Alt with an arrow', () => {
  const data = { steps: [{ log: 'a' }, { parallel: [{ log: 'b' }, { log: 'c' }] }, { log: 'd' }] }

  test('goes past a neighbour, and out of a structure at its edge', () => {
    expect(moveOf(data, ['steps', 0], 'down')).toMatchObject({ to: ['steps'], index: 2 })
    expect(moveOf(data, ['steps', 1, 'parallel', 0], 'up')).toMatchObject({ to: ['steps'], index: 1 })
    expect(moveOf(data, ['steps', 1, 'parallel', 1], 'down')).toMatchObject({ to: ['steps'], index: 2 })
    expect(moveOf(data, ['steps', 0], 'up')).toBe(null)
  })

  test('goes into the structure above', () => {
    expect(moveOf(data, ['steps', 2], 'in')).toMatchObject({ to: ['steps', 1, 'parallel'], index: 2 })
  })

  test('a new step goes inside, after, or to the end', () => {
    expect(placeAfter(data, ['steps', 1], true)).toEqual({ list: ['steps', 1, 'parallel'], index: 2 })
    expect(placeAfter(data, ['steps', 1], false)).toEqual({ list: ['steps'], index: 2 })
    expect(placeAfter(data, [], false)).toEqual({ list: ['steps'], index: 3 })
  })
})

test('line breaks of Windows come back, a mixture stays as it is', () => {
  const windows = withoutBreaks('a\r\nb\r\n')
  const mixed = withoutBreaks('a\r\nb\n')

  expect([windows.text, windows.restore('a\nc\n')]).toEqual(['a\nb\n', 'a\r\nc\r\n'])
  expect([mixed.text, mixed.restore('a\r\nb\n')]).toEqual(['a\r\nb\n', 'a\r\nb\n'])
})

test('a used protocol is found from the file that uses it', () => {
  expect(fileOf('night/all.yaml', './scan.yaml')).toBe('night/scan.yaml')
  expect(fileOf('night/all.yaml', '../scan.yaml')).toBe('scan.yaml')
})

test('what is pasted has the line breaks of the editor, wherever it was copied', () => {
  const state = stateOf('', { save: () => undefined, fix: () => false }, [])

  expect(state.facet(EditorView.clipboardInputFilter).reduce((text, filter) => filter(text, state), 'a\r\nb\rc\n')).toBe('a\nb\nc\n')
})

test.each([
  ['devices:', 2], ['    with:', 6], ['  - foreach:', 6], ['steps:  ', 2],
])('the line after “%s” begins at column %i', (line, column) => {
  const state = stateOf(`labrun: 1\n${line}`, { save: () => undefined, fix: () => false }, [])
  const at = state.doc.length

  expect(getIndentation(new IndentContext(state, { simulateBreak: at }), at)).toBe(column)
})
