// Conditions as forms: what is read from an expression, and what is written.
import { expect, test } from 'vitest'
import { conditionOf, lookedAt, shownRight, writtenCondition, writtenRight } from './conditions'

test('what a form reads, it writes as it was', () => {
  for (const text of [
    '${{ status.oven.temperature > 950 degC }}', '${{ not status.leak.wet }}', '${{ ready }}', "${{ answer == 'go on or stop' }}", '${{ answer == "it\'s this or that" or a }}', '${{ turn < 4 and steps.read.ph <= 7.2 }}',
    '${{ steps.look.samples[0].area >= 2.5e-3 mm }}', '${{ a or not b or c != d }}', "${{ kind != 'salt and pepper' and n == -1 }}", '${{ status.pump.flow < 3 mL/min }}',
  ]) {
    const condition = conditionOf(text)
    expect(condition && writtenCondition(condition), text).toBe(text)
  }
})

test('anything else stays an expression', () => {
  for (const text of [
    'ready', true, undefined, '${{ true }}', '${{ false }}', '${{ a and b or c }}', '${{ abs(x) > 1 }}', '${{ x + 1 > 2 }}', '${{ (a) }}', '${{ 3 < x }}', '${{ not a == b }}',
    '${{ 1 < x < 3 }}', "${{ name in ['a', 'b'] }}", '${{ elapsed() < 8 h }}', '${{ a  ==  b }}', '${{ }}',
  ]) expect(conditionOf(text), String(text)).toBe(null)
})

test('a typed number gets the unit of what it is compared with, a text its quotes', () => {
  expect(writtenRight('950', { kind: 'number', unit: 'degC' })).toBe('950 degC')
  expect(writtenRight('', { kind: 'number', unit: 'degC' })).toBe('0 degC')
  expect(writtenRight('950 K', { kind: 'number', unit: 'degC' })).toBe('950 K')
  expect(['7,5', '−3'].map((typed) => writtenRight(typed, { kind: 'number', unit: 'mm' }))).toEqual(['7.5 mm', '-3 mm'])
  expect(writtenRight("it's", { kind: 'text', unit: '' })).toBe('"it\'s"')
  expect(shownRight('"it\'s"')).toBe("it's")
  expect(writtenRight('', undefined)).toBe('0')
  expect(shownRight("'go on'")).toBe('go on')
})

test('a watch may look at the status of the devices, a step at what came before it', () => {
  const data = {
    params: { limit: { type: 'number', unit: 'degC', default: 900 }, careful: { type: 'boolean' } },
    devices: { oven: 'furnace@1' },
    steps: [{ set: { turn: 0 } }, { steps: [{ do: 'oven.ramp' }] }],
  }
  const status_schema = { properties: { temperature: { type: 'number', unit: 'degC' }, door_open: { type: 'boolean' } } }
  const contracts = { deviceOf: () => ({ status_schema, actions: [] }) } as unknown as Parameters<typeof lookedAt>[2]
  const words = (watching: boolean): string[] => lookedAt(data, ['steps', 1], contracts, watching).map((one) => `${one.words} ${one.kind} ${one.unit}`.trim())

  expect(words(true)).toEqual(['status.oven.temperature number degC', 'status.oven.door_open truth', 'turn list', 'run.simulated truth', 'params.limit number degC', 'params.careful truth'])
  expect(words(false)).toEqual(['turn list', 'run.simulated truth', 'params.limit number degC', 'params.careful truth'])
})
