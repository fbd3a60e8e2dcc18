// A field of a form from a contract's schema: what it accepts, shows and writes.
import { isNumber, pointed } from '../../ui/format'
import { isMap } from '../text/path'

export interface Field {
  name: string
  kind: 'number' | 'text' | 'choice' | 'truth' | 'list'
  unit: string
  choices: string[]
  required: boolean
  about: string
  placeholder: string
  /** Expressions are not allowed here. */
  plain?: boolean
  /** A list of texts: `007` is no number. */
  texts?: boolean
}

type Schema = Record<string, unknown>

/** The fields of an action's parameters, required ones first. */
export function fieldsOf(params: Schema): Field[] {
  const properties = isMap(params['properties']) ? params['properties'] : {}
  const required = new Set(Array.isArray(params['required']) ? params['required'].map(String) : [])
  const fields = Object.entries(properties).map(([name, part]) => fieldOf(name, isMap(part) ? part : {}, required.has(name)))
  return [...fields.filter((one) => one.required), ...fields.filter((one) => !one.required)]
}

function fieldOf(name: string, part: Schema, required: boolean): Field {
  const types = Array.isArray(part['type']) ? part['type'].map(String) : [String(part['type'] ?? '')]
  const choices = Array.isArray(part['enum']) ? part['enum'].map(String) : []
  const number = types.includes('number') || types.includes('integer')
  const kind = choices.length > 0 ? 'choice' : types.includes('boolean') ? 'truth' : number ? 'number' : types.includes('array') ? 'list' : 'text'
  const unit = typeof part['unit'] === 'string' ? part['unit'] : ''
  const told = typeof part['description'] === 'string' ? part['description'] : ''
  const fallback = part['default'] === undefined ? '' : `${String(part['default'] as string | number)} ${unit}`.trim()
  return { name, kind, unit, choices, required, about: [told, rangeText(part)].filter(Boolean).join(' · '), placeholder: fallback || unit, texts: isMap(part['items']) && part['items']['type'] === 'string' }
}

/** `0–730 mm`, `more than 0 mm`, `1 or more`. */
export function rangeText(part: Schema): string {
  const unit = typeof part['unit'] === 'string' ? ` ${part['unit']}` : ''
  const [low, high, above] = [part['minimum'], part['maximum'], part['exclusiveMinimum']]
  const has = (one: unknown): one is number => typeof one === 'number'
  if (has(low) && has(high)) return `${String(low)}–${String(high)}${unit}`
  if (has(above)) return `more than ${String(above)}${has(high) ? ` to ${String(high)}` : ''}${unit}`
  if (has(low)) return `${String(low)}${unit} or more`
  if (has(high)) return `up to ${String(high)}${unit}`
  return unit.trim()
}

/** A value as text in a field. */
export function asText(value: unknown, texts = false): string {
  if (value === undefined || value === null) return ''
  if (Array.isArray(value)) return value.every((one) => typeof one !== 'object') ? value.map((one) => itemText(one, texts)).join(', ') : JSON.stringify(value)
  return typeof value === 'object' ? JSON.stringify(value) : String(value as string | number | boolean)
}

/** The typed text as a value: empty is `undefined`, and a bare number gets the field's unit. */
export function asValue(written: string, kind: Field['kind'], unit = '', texts = false): unknown {
  const text = written.trim()
  if (text === '') return undefined
  if (text.includes('${{')) return text
  if (kind === 'truth') return text === 'true' || text === 'on' || (text === 'false' || text === 'off' ? false : text)
  if (kind === 'list') return (text.replace(/^\[|\]$/g, '').match(/\s*"(?:[^"\\]|\\.)*"\s*(?=,|$)|[^,]+/g) ?? []).map((one) => one.trim()).filter(Boolean).map((one) => itemOf(one, texts))
  const number = pointed(text)
  if (kind === 'number' && isNumber(number)) return unit === '' ? Number(number) : `${number} ${unit}`
  return kind === 'number' ? number : text
}

/** `007`, `1E5` and twenty digits name something: as numbers they would be something else. */
function itemOf(text: string, texts: boolean): unknown {
  if (/^".*"$/.test(text)) {
    try {
      return JSON.parse(text)
    } catch {
      return text
    }
  }
  const plain = pointed(text)
  return !texts && isNumber(plain) && !/^[-+]?0\d|\de\d|\d{16}/i.test(plain) ? Number(plain) : text
}

/** In quotes where it would be read as something else. */
function itemText(item: unknown, texts: boolean): string {
  const text = String(item)
  return typeof item === 'string' && (text === '' || text !== text.trim() || /[",[\]]/.test(text) || itemOf(text, texts) !== text) ? JSON.stringify(text) : text
}
