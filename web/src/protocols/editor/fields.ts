// A field of a form from a contract's schema: what it accepts, shows and writes.
import { isNumber, pointed } from '../../ui/format'
import { itemOf, itemText, listOf, listText } from '../../ui/lists'
import { parse } from 'yaml'
import { isMap } from '../text/path'

export interface Field {
  name: string
  /** `value`: whatever was typed, a number, yes or no, or a text; `fields`: `{name: …}`. */
  kind: 'number' | 'text' | 'choice' | 'truth' | 'list' | 'value' | 'fields'
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
  const kind = choices.length > 0 ? 'choice' : types.includes('boolean') ? 'truth' : number ? 'number' : types.includes('array') ? 'list' : types.includes('object') ? 'fields' : 'text'
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
export function asText(value: unknown, texts = false, kind: Field['kind'] = 'text'): string {
  if (value === undefined || value === null) return ''
  if (Array.isArray(value)) return value.every((one) => typeof one !== 'object') ? listText(value, texts) : JSON.stringify(value)
  if (typeof value === 'string' && kind === 'value') return /^(true|false)$/.test(value) ? JSON.stringify(value) : itemText(value, false, /^"/)
  return typeof value === 'object' ? JSON.stringify(value) : String(value as string | number | boolean)
}

/** The typed text as a value: empty is `undefined`, and a bare number gets the field's unit. */
export function asValue(written: string, kind: Field['kind'], unit = '', texts = false): unknown {
  const text = written.trim()
  if (text === '') return undefined
  if (text.includes('${{')) return text
  if (kind === 'truth') return text === 'true' || text === 'on' || (text === 'false' || text === 'off' ? false : text)
  if (kind === 'list') return listOf(text, texts)
  if (kind === 'value') return text === 'true' || (text === 'false' ? false : itemOf(text))
  if (kind === 'fields') return fieldsIn(text)
  const number = pointed(text)
  if (kind === 'number' && isNumber(number)) return unit === '' ? Number(number) : `${number} ${unit}`
  return kind === 'number' ? number : text
}

/** `{red: [0, 200]}`; anything else stays the text that it is, and the check says what is missing. */
function fieldsIn(text: string): unknown {
  try {
    const read: unknown = parse(text)
    return isMap(read) ? read : text
  } catch {
    return text
  }
}
