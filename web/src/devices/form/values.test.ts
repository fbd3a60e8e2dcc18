import { describe, expect, it } from 'vitest'
import { fieldsOf, rangeOf } from './fields'
import type { Schema } from './schema'
import { valuesOf } from './values'

const MOVE: Schema = {
  type: 'object', minProperties: 1,
  properties: {
    x: { type: 'number', unit: 'mm', minimum: 0, maximum: 730 },
    feed: { type: 'number', unit: 'mm/min', exclusiveMinimum: 0, maximum: 2500 },
  },
}
const CAPTURE: Schema = {
  type: 'object', required: ['image'],
  properties: {
    depth: { type: 'string', format: 'path' },
    image: { type: 'string', format: 'path' },
    shots: { type: 'integer', minimum: 1, maximum: 50, default: 3 },
    argon: { type: 'boolean', default: true },
    mode: { enum: ['fast', 7] },
  },
}

describe('fields of a contract', () => {
  it('come with the required ones first and the others folded', () => {
    const fields = fieldsOf(CAPTURE)

    expect(fields.map((field) => [field.name, field.folded])).toEqual([
      ['image', false], ['depth', true], ['shots', true], ['argon', true], ['mode', true],
    ])
  })

  it('are all open where none is required', () => {
    expect(fieldsOf(MOVE).some((field) => field.folded)).toBe(false)
    expect(fieldsOf({ properties: { x: { type: 'number', default: 0 }, touched: { type: 'array' } } }).map((field) => field.folded)).toEqual([false, true])
  })

  it('show their range with its unit', () => {
    expect(fieldsOf(MOVE).map((field) => field.range)).toEqual(['0–730 mm', 'more than 0 to 2500 mm/min'])
    expect(rangeOf({ maximum: 4 })).toBe('at most 4')
  })
})

describe('what was typed', () => {
  const move = fieldsOf(MOVE)

  it('is a number, a number with its own unit, or left out', () => {
    expect(valuesOf(move, { x: '104.2', feed: '' }).params).toEqual({ x: 104.2 })
    expect(valuesOf(move, { x: '2 cm' }).params).toEqual({ x: '2 cm' })
    expect(valuesOf(move, { x: '10,5' }).params).toEqual({ x: 10.5 })
    expect(valuesOf(move, { x: '−3' }).faults).toEqual({ x: '-3 is outside 0–730 mm' })
  })

  it('gets an error message', () => {
    expect(valuesOf(move, { x: '731' }).faults).toEqual({ x: '731 is outside 0–730 mm' })
    expect(valuesOf(move, { x: 'left' }).faults).toEqual({ x: 'enter a number, in mm or with its unit' })
    expect(valuesOf(move, { feed: '0' }).faults).toEqual({ feed: '0 is outside more than 0 to 2500 mm/min' })
    expect(valuesOf(move, {}, 1).faults).toEqual({ x: 'give at least 1 of these' })
  })

  it('keeps the type in the contract', () => {
    const fields = fieldsOf(CAPTURE)
    const taken = valuesOf(fields, { image: 'a.png', shots: '2.5', mode: '7', argon: false })

    expect(taken.params).toEqual({ image: 'a.png', mode: 7, argon: false })
    expect(taken.faults).toEqual({ shots: 'enter a whole number' })
    expect(valuesOf(fields, {}).faults).toEqual({ image: 'image is required' })
  })
})
