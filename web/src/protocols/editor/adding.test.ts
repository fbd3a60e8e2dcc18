// "Add step": what is written, and what it takes from the steps and loops around it.
import { expect, test } from 'vitest'
import type { ActionForm, DeviceDetail } from '../../api/types'
import { patchAll } from '../text/edit'
import type { Path } from '../text/path'
import { read } from '../text/reading'
import { actionOffers, matching, plainOffers, structureOffers } from './adding'
import { sourcesAt } from './around'

function action(name: string, params: unknown = {}, returns: unknown = {}, more: Partial<ActionForm> = {}): ActionForm {
  return { name, summary: '', params, returns, errors: {}, effect: 'pure', danger: null, level: 0, cancel: false, duration_s: 1, ...more } as unknown as ActionForm
}
const mm = { type: 'number', unit: 'mm', minimum: 0 }
const file = { type: 'string', format: 'path' }
const devices = [
  { name: 'gantry', contract: 'gantry@1', reach: 'online', safe_state: [], actions: [
    action('home', {}, {}, { danger: 'motion' }),
    action('move_to', { minProperties: 1, properties: { x: mm, y: mm, z: mm } }, { properties: { x: mm, y: mm, z: mm } }, { danger: 'motion' }),
  ] },
  { name: 'libs', contract: 'libs_analyzer@1', reach: 'online', safe_state: ['disarm'], actions: [
    action('measure', {}, { properties: { shot_id: { type: 'string' } } }, { level: 3 }),
    action('export', { required: ['shot', 'file'], properties: { shot: { type: 'string' }, file } }, { properties: { file } }),
  ] },
  { name: 'reduce', contract: 'spectrum_reducer@1', reach: 'online', safe_state: [], actions: [action('reduce', { required: ['spectrum'], properties: { spectrum: file, elements: { type: 'array' } } })] },
] as unknown as DeviceDetail[]
const contracts = { devices, reach: new Map(), deviceOf: (contract: string) => devices.find((one) => one.contract === contract) ?? null }

function add(text: string, words: string, path: Path, inside = false): { text: string; select: Path } {
  const now = read(text)
  const offer = [...actionOffers(contracts, []), ...structureOffers(devices, []), ...plainOffers([], 'mine')].find((one) => one.name === words)
  if (!now.ok || !offer) throw new Error(`no ${words}`)
  const done = patchAll(text, offer.edits(now.data, path, inside))
  if (!done.ok) throw new Error(done.reason)
  return done
}

test('a scan is built from an empty protocol without typing an expression', () => {
  let now = add('labrun: 1\nname: mine\nsteps: []\n', 'For each', [])
  for (const [words, inside] of [['libs: measure', true], ['libs: export', false], ['reduce: reduce', false]] as const) now = add(now.text, words, now.select, inside)

  expect(now.text).toBe(`labrun: 1
name: mine
devices: {gantry: gantry@1, libs: libs_analyzer@1, reduce: spectrum_reducer@1}
steps:
  - id: scan
    foreach:
      point: \${{ grid(x=span(0 mm, 10 mm, 2 mm), y=span(0 mm, 10 mm, 2 mm), order='snake') }}
    key: \${{ point.ix }},\${{ point.iy }}
    steps:
      - {do: gantry.move_to, with: {x: "\${{ point.x }}", y: "\${{ point.y }}"}}
      - id: measure
        do: libs.measure
      - id: export
        do: libs.export
        with:
          shot: \${{ steps.measure.shot_id }}
          file: export_\${{ point.ix }}_\${{ point.iy }}.csv
      - {do: reduce.reduce, with: {spectrum: "\${{ steps.export.file }}"}}
`)
})

test('another way, and what happens otherwise, begin the lists that are not there yet', () => {
  const [step, otherwise] = [['steps', 0], ['steps', 0, 'else']]
  const now = add('labrun: 1\nname: mine\nsteps:\n  - if: ${{ true }}\n    then:\n      - wait: 1 s\n', 'Log', otherwise)

  expect(now.text).toContain('    then:\n      - wait: 1 s\n    else:\n      - log: Here\n')
  expect(add(now.text, 'Wait', otherwise).text).toContain('    else:\n      - log: Here\n      - wait: 5 s\n')
  expect(add(now.text, 'Wait', [...step, 'fallback']).text).toContain('    fallback:\n      - wait: 5 s\n')
})

test('a search finds names before descriptions, and an action as a protocol writes it', () => {
  const offers = [...structureOffers(devices, []), ...actionOffers(contracts, []), ...plainOffers([], 'mine')]
  const first = (words: string) => matching(offers, words)[0]?.name

  expect([first('if'), first('log'), first('move_to'), first('gantry.home'), first('fails')]).toEqual(['If', 'Log', 'gantry: move to', 'gantry: home', 'Try in order'])
})

test('outside of a loop of points there is no point to take', () => {
  const text = 'labrun: 1\nname: a\ndevices: {gantry: gantry@1}\nsteps:\n  - foreach: {point: [1, 2]}\n    steps:\n      - wait: 1 s\n'

  expect(add(text, 'gantry: move to', ['steps', 0]).text).toContain('- {do: gantry.move_to, with: {x: 0 mm}}')
  expect(add(text, 'gantry: move to', ['steps', 0, 'steps', 0]).text).toContain('with: {x: 0 mm}')
})

test('a loop in a loop has a name of its own', () => {
  const first = add('labrun: 1\nname: a\nsteps: []\n', 'For each', [])
  const second = add(first.text, 'For each', first.select, true)

  expect(second.text).toContain('point_2: ${{ grid(')
  expect(second.text).toContain('with: {x: "${{ point_2.x }}", y: "${{ point_2.y }}"}')
  expect(second.text).toContain('- id: scan_2')
})

test('what runs at the same time, or later, cannot be taken from', () => {
  const now = read(`labrun: 1
devices: {gantry: gantry@1}
steps:
  - {do: gantry.move_to, with: {x: 1 mm}}
  - parallel:
      - {id: side, do: gantry.move_to, with: {x: 1 mm}}
      - {do: gantry.home}
  - {id: later, do: gantry.move_to, with: {x: 1 mm}}
`)
  if (!now.ok) throw new Error(now.message)
  const words = (path: Path): string[] => sourcesAt(now.data, path, contracts).map((one) => one.words)

  expect(words(['steps', 1, 'parallel', 1])).toEqual(['steps.move_to.x', 'steps.move_to.y', 'steps.move_to.z'])
  expect(words(['steps', 2])).toEqual(expect.arrayContaining(['steps.side.x', 'steps.move_to.x']))
  expect(words(['steps', 2])).not.toContain('steps.later.x')
})

test('the columns of a table can be taken from, each with its unit', () => {
  const now = read('labrun: 1\nsteps:\n  - foreach: {well: "${{ csv(\'wells.csv\') }}"}\n    steps:\n      - wait: 1 s\n')
  if (!now.ok) throw new Error(now.message)
  const tables = [{ name: 'wells.csv', rows: 2, columns: ['place', 'x', 'acid_used'], kinds: ['text', 'mm', 'boolean'], fault: null }]
  const found = sourcesAt(now.data, ['steps', 0, 'steps', 0], { ...contracts, tables })

  expect(found.map(({ label, words, kind, unit }) => [label, words, kind, unit])).toEqual([
    ['place of the well', 'well.place', 'text', ''], ['x of the well', 'well.x', 'number', 'mm'], ['acid used of the well', 'well.acid_used', 'truth', ''],
  ])
})
