import { expect, it } from 'vitest'
import { statusLine, statusValues } from './statusWords'

const SCHEMA = { properties: { x: { type: 'number', unit: 'mm' }, mass: { type: 'number', unit: 'g' }, volume: { type: 'number', unit: 'uL' }, left: { type: 'object' } } }

it('says a status as a person reads it', () => {
  const status = { x: -1.234, mass: 12.34567, volume: 250, left: { water: 250, acid: 12.5 }, lid: false, state: 'idle' }

  expect(statusValues(status, SCHEMA).map((one) => [one.value, one.unit])).toEqual([['−1.23', 'mm'], ['12.3457', 'g'], ['250', 'µL'], ['water 250, acid 12.5', ''], ['no', ''], ['idle', '']])
  expect(statusLine({ ...status, mass: undefined }, SCHEMA, 'idle')).toBe('x −1.23 · volume 250 µL · left water 250, acid 12.5 · lid no')
})
