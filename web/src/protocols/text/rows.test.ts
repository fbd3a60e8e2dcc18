// The outline: titles, places, and what is visible while rows are closed.
import { expect, test } from 'vitest'
import { firstOn, RowIndex, rangeOf, seenRows } from './finding'
import { fromPointer, toPointer } from './path'
import { read, type Read } from './reading'
import { rowsOf, type Row } from './rows'

const TEXT = `labrun: 1
name: map
finally:
  - {do: libs.disarm}
steps:
  - id: scan
    foreach: {point: "\${{ grid() }}"}
    steps:
      - {do: gantry.move_to, with: {x: "\${{ point.x }}", z: 0 mm}}
      - if: \${{ point.ix > 3 }}
        then:
          - {wait: 1 s}
        else:
          - {fail: too far}
      - do: libs.measure
        fallback:
          - {log: dark}
`

function sound(text: string): Read {
  const reading = read(text)
  if (!reading.ok) throw new Error(reading.message)
  return reading
}

const reading = sound(TEXT)
const rows = rowsOf(reading)

test('rows describe what happens, in the order of the language', () => {
  const words = rows.map((row) => `${' '.repeat(row.level - 1)}${row.title}`)

  expect(words).toEqual([
    'map', 'For each point', ' Move to', ' If point.ix > 3', '  Wait 1 s', '  Otherwise', '   Fail', ' Measure', '  If it fails, try in order', '   Write to the log',
    'Always at the end', ' Disarm',
  ])
  expect(rows[2]?.detail).toBe('gantry · x = point.x, z 0 mm')
})

test('a row knows its position among its siblings, and where its children end', () => {
  expect([rows[3]?.position, rows[3]?.setSize, rows[3]?.end]).toEqual([2, 3, 7])
  expect(rows[6]?.parent).toBe(5)
})

test('an offset finds its row, a row its place, a pointer its step', () => {
  const index = new RowIndex(rows)

  expect(rows[index.at(TEXT.indexOf('too far'))]?.title).toBe('Fail')
  expect(rows[index.at(TEXT.indexOf('libs.disarm'))]?.title).toBe('Disarm')
  expect(rangeOf(reading, ['steps', 0, 'steps', 0, 'with', 'z'])).toEqual({ from: TEXT.indexOf('0 mm'), to: TEXT.indexOf('0 mm') + 4 })
  expect(index.of(fromPointer('/steps/0/steps/0/with/z', reading.data))).toBe(2)
})

test('the contents of a closed row are hidden', () => {
  const closed = new Set([toPointer(['steps', 0, 'steps', 1])])
  const seen = [...seenRows(rows, closed)].map((i) => rows[i]?.title)

  expect(seen).toEqual(['map', 'For each point', 'Move to', 'If point.ix > 3', 'Measure', 'If it fails, try in order', 'Write to the log', 'Always at the end', 'Disarm'])
})

test('a hundred thousand rows are listed, found and closed', () => {
  const row = (i: number): Row => ({ path: ['steps', i], kind: 'do', title: `Step ${String(i)}`, detail: '', id: '', from: i * 10, to: i * 10 + 8, level: 1, parent: -1, end: i + 1, position: i + 1, setSize: 100_000 })
  const many = Array.from({ length: 100_000 }, (_, i) => row(i))
  const index = new RowIndex(many)

  expect(index.at(777_774)).toBe(77_777)
  expect(seenRows(many, new Set(['/steps/5'])).length).toBe(100_000)
})

test('what a loop runs over is told in words', () => {
  const told = (items: string): string | undefined => rowsOf(sound(`steps: [{foreach: {one: "\${{ ${items} }}"}}]\n`)).find((row) => row.kind === 'foreach')?.detail

  expect(told("inside(grid(x=[1 mm], y=[2 mm]), csv('core.csv'), 1 mm)")).toBe('a grid inside core.csv')
  expect(told('inside(grid(x=[1 mm], y=[2 mm]), steps.find.outline)')).toBe('a grid inside steps.find.outline')
  expect(told("csv('samples.csv')")).toBe('rows of samples.csv')
  expect(told('span(0 mm, params.width, 2 mm)')).toBe('0 mm to width by 2 mm')
  expect(told('range(3)')).toBe('range(3)')
})

test('a link to a line leads to the step that begins on it, not to the one around it', () => {
  const lines = TEXT.split('\n')
  const titled = (words: string): string | undefined => {
    const at = lines.findIndex((line) => line.includes(words))
    const from = lines.slice(0, at).join('\n').length + 1
    return rows[new RowIndex(rows).at(from + firstOn(lines[at] ?? ''))]?.title
  }

  expect(['id: scan', 'gantry.move_to', 'libs.measure', 'log: dark'].map(titled)).toEqual(['For each point', 'Move to', 'Measure', 'Write to the log'])
})
