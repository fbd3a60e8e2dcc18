import { expect, test } from 'vitest'
import { chosen, fault, rangeWords, sent, shownDefault, understood, type ParamForm } from './params'

const base = { unit: null, default: null, required: false, minimum: null, maximum: null, pattern: null, enum: null, summary: '' }
const pitch: ParamForm = { ...base, name: 'pitch', type: 'quantity', unit: 'mm', default: '0.2 mm', minimum: '0.02 mm', maximum: '10 mm' }
const shots: ParamForm = { ...base, name: 'shots', type: 'integer', default: 3, minimum: 1, maximum: 50, required: true }
const sample: ParamForm = { ...base, name: 'sample', type: 'string', default: 'core', pattern: '^[A-Z]+$' }

test('a quantity is typed without its unit and sent with it', () => {
  expect(shownDefault(pitch)).toBe('0.2')
  expect(sent(pitch, '0,5')).toBe('0.5 mm')
  expect(sent(pitch, '100 um')).toBe('100 um')
})

test('a field says what it must be', () => {
  expect(rangeWords(pitch)).toBe('0.02–10 mm')
  expect(fault(pitch, '0.001')).toBe('at least 0.02 mm')
  expect(fault(pitch, '11')).toBe('at most 10 mm')
  expect(fault(shots, '2.5')).toBe('enter a whole number')
  expect(fault(shots, '')).toBe('needed')
  expect(fault(shots, 'many')).toBe('enter a number')
  expect(fault(sample, 'core')).toBe('must match ^[A-Z]+$')
  expect(fault({ ...sample, pattern: '^[A-Za-z0-9_-]{1,40}$' }, 'core 17')).toBe('only letters A–Z, digits, _ and -, at most 40')
})

test('a list is read as it is typed, and what was understood is said', () => {
  const volumes: ParamForm = { ...base, name: 'volumes', type: 'array', default: [10, '20 ul'] }

  expect(shownDefault(volumes)).toBe('10, 20 ul')
  expect(['0,5', '0,5; 1,5', '1, 2', '[3, 4]', '007', '[[1, 2], [3]]'].map((one) => sent(volumes, one))).toEqual([[0.5], [0.5, 1.5], [1, 2], [3, 4], ['007'], '[[1, 2], [3]]'])
  expect([understood(volumes, '0,5'), understood(volumes, '1,2,3'), understood(volumes, '10, 20 ul'), understood(pitch, '0,5')]).toEqual(['1 item: 0.5', '3 items: 1 · 2 · 3', '', ''])
})

test('another unit is left to the server to judge', () => {
  expect(fault(pitch, '4 s')).toBe('')
})

test('only what differs from the defaults is sent', () => {
  expect(chosen([pitch, shots, sample], { pitch: '0.2', shots: '5', sample: '' })).toEqual({ shots: 5 })
})
