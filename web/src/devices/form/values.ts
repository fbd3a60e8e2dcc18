// What a person typed as values for the server, or the reason why not.
import { isNumber, pointed } from '../../ui/format'
import type { Field } from './fields'
import { type Schema } from './schema'

export type Typed = Record<string, string | boolean>

export interface Taken {
  params: Record<string, unknown>
  faults: Record<string, string>
}

const WITH_UNIT = /^[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*[^\d\s.,+-].*$/i

/** Every field; empty ones are left out. Numbers may have their own unit: `2 cm`. */
export function valuesOf(fields: readonly Field[], typed: Typed, least = 0): Taken {
  const taken: Taken = { params: {}, faults: {} }
  for (const field of fields) {
    const given = typed[field.name] ?? field.first
    const [value, fault] = valueOf(field, given)
    if (fault !== '') taken.faults[field.name] = fault
    else if (value !== undefined) taken.params[field.name] = value
  }
  const none = Object.keys(taken.params).length < least && Object.keys(taken.faults).length === 0
  const first = fields[0]
  if (none && first !== undefined) taken.faults[first.name] = `give at least ${least} of these`
  return taken
}

function valueOf(field: Field, given: string | boolean): [unknown, string] {
  if (typeof given === 'boolean') return [given, '']
  const text = given.trim()
  if (text === '') return [undefined, field.required ? `${field.name} is required` : '']
  switch (field.kind) {
    case 'number':
    case 'integer':
      return numberOf(field, pointed(text))
    case 'choice':
      return [field.schema.enum?.[field.choices.indexOf(text)], '']
    case 'json':
      return jsonOf(text)
    default:
      return [given, textFault(field.schema, text)]
  }
}

function numberOf(field: Field, text: string): [unknown, string] {
  if (isNumber(text)) {
    const value = Number(text)
    return [value, outside(field, value)]
  }
  if (field.unit !== '' && WITH_UNIT.test(text)) return [text, ''] // the server knows units
  return [undefined, field.unit === '' ? 'enter a number' : `enter a number, in ${field.unit} or with its unit`]
}

function outside(field: Field, value: number): string {
  const { minimum, maximum, exclusiveMinimum, exclusiveMaximum } = field.schema
  const low = (minimum !== undefined && value < minimum) || (exclusiveMinimum !== undefined && value <= exclusiveMinimum)
  const high = (maximum !== undefined && value > maximum) || (exclusiveMaximum !== undefined && value >= exclusiveMaximum)
  if (low || high) return `${value} is outside ${field.range}`
  if (field.kind === 'integer' && !Number.isInteger(value)) return 'enter a whole number'
  return ''
}

function textFault(schema: Schema, text: string): string {
  if (schema.minLength !== undefined && text.length < schema.minLength) return `at least ${schema.minLength} characters`
  if (schema.maxLength !== undefined && text.length > schema.maxLength) return `at most ${schema.maxLength} characters`
  if (schema.pattern !== undefined && !new RegExp(schema.pattern, 'u').test(text)) return `must match ${schema.pattern}`
  return ''
}

function jsonOf(text: string): [unknown, string] {
  try {
    return [JSON.parse(text), '']
  } catch {
    return [undefined, 'write it as JSON, for example [1, 2]']
  }
}
