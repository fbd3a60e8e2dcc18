// An action's parameters as fields of a form, in the order in which a person fills them in.
import { number } from '../../ui/format'
import { type Schema, typeOf } from './schema'

export type FieldKind = 'number' | 'integer' | 'boolean' | 'choice' | 'text' | 'json'

export interface Field {
  name: string
  kind: FieldKind
  unit: string
  required: boolean
  /** Folded away: it may stay as it is while others are required, or is a list or map. */
  folded: boolean
  range: string
  about: string
  first: string | boolean
  choices: readonly string[]
  schema: Schema
}

/** Required ones first; what seldom changes comes folded. */
export function fieldsOf(params: Schema): Field[] {
  const required = new Set(params.required ?? [])
  const fields = Object.entries(params.properties ?? {}).map(([name, schema]) => {
    const kind = kindOf(schema)
    return {
      name, kind, schema,
      unit: schema.unit ?? '',
      required: required.has(name),
      folded: !required.has(name) && (required.size > 0 || kind === 'json'),
      range: rangeOf(schema),
      about: schema.description ?? schema.title ?? '',
      first: firstOf(schema, kind),
      choices: (schema.enum ?? []).map((one) => wordOf(one)),
    }
  })
  const rank = (field: Field): number => (field.required ? 0 : field.folded ? 2 : 1)
  const shown = fields.sort((a, b) => rank(a) - rank(b))
  // A form with only folded fields would look empty.
  return shown.every((field) => field.folded) ? shown.map((field) => ({ ...field, folded: false })) : shown
}

/** Strings stay as they are; everything else as JSON. */
export function wordOf(value: unknown): string {
  return typeof value === 'string' ? value : JSON.stringify(value)
}

function kindOf(schema: Schema): FieldKind {
  if (schema.enum !== undefined) return 'choice'
  const type = typeOf(schema)
  if (type === 'number' || type === 'integer' || type === 'boolean') return type
  return type === 'string' ? 'text' : 'json'
}

function firstOf(schema: Schema, kind: FieldKind): string | boolean {
  if (kind === 'boolean') return schema.default === true
  return schema.default === undefined ? '' : wordOf(schema.default)
}

/** `0–730 mm`, `more than 0 mm`, `1–50`; empty without bounds. */
export function rangeOf(schema: Schema): string {
  const unit = schema.unit === undefined ? '' : ` ${schema.unit}`
  const low = schema.minimum ?? schema.exclusiveMinimum
  const high = schema.maximum ?? schema.exclusiveMaximum
  const above = schema.minimum === undefined && low !== undefined
  if (low !== undefined && high !== undefined) {
    return above ? `more than ${number(low)} to ${number(high)}${unit}` : `${number(low)}–${number(high)}${unit}`
  }
  if (low !== undefined) return `${above ? 'more than' : 'at least'} ${number(low)}${unit}`
  if (high !== undefined) return `at most ${number(high)}${unit}`
  return ''
}
