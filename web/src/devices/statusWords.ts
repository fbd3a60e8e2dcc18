// A status as values with units, for the list and for the detail.
import { allOf, valueWords } from '../runs/valueWords'
import { mm, figures } from '../ui/format'
import type { Schema } from './form/schema'

export interface StatusValue {
  name: string
  value: string
  /** With every digit. */
  full: string
  unit: string
  about: string
}

/** Every value in the contract's order, then those that the contract does not name. */
export function statusValues(status: Readonly<Record<string, unknown>>, schema: Schema | undefined): StatusValue[] {
  const known = schema?.properties ?? {}
  const names = [...Object.keys(known), ...Object.keys(status).filter((name) => !(name in known))]
  return names.map((name) => ({
    name,
    value: valueWord(status[name], known[name]),
    full: allOf(status[name]),
    unit: (known[name]?.unit ?? '').replace(/^u(?=[A-Z])/, 'µ'),
    about: known[name]?.description ?? '',
  }))
}

/** One value as text; a length always has two decimals. */
export function valueWord(value: unknown, schema?: Schema): string {
  if (value === undefined || value === null) return '–'
  if (typeof value === 'boolean') return value ? 'yes' : 'no'
  if (typeof value === 'number') {
    return schema?.unit === 'mm' ? mm(value) : figures(value).replace('-', '−')
  }
  return valueWords(value)
}

/** One line for the list: `x 104.20 · y 201.00 · z 0.00`. */
export function statusLine(status: Readonly<Record<string, unknown>>, schema: Schema | undefined, word: string): string {
  return statusValues(status, schema)
    .filter((one) => one.value !== '–' && one.value !== word)
    .slice(0, 4)
    .map((one) => `${one.name} ${one.value}${one.unit && one.unit !== 'mm' ? ` ${one.unit}` : ''}`)
    .join(' · ')
}
