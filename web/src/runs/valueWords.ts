// A value out of the journal as a person writes it: quantities with their unit.
import { exact } from '../ui/format'

export function valueWords(value: unknown): string {
  if (value === null || value === undefined) return '–'
  if (typeof value === 'number') return exact(value)
  if (Array.isArray(value)) return value.length > 8 ? `${value.length} values` : value.map(valueWords).join(', ')
  if (typeof value !== 'object') return String(value)
  const quantity: unknown = (value as Record<string, unknown>)['$quantity']
  if (Array.isArray(quantity)) return `${valueWords(quantity[0])} ${String(quantity[1])}`
  if ('$moment' in value) return String(value.$moment)
  return Object.entries(value).map(([name, one]) => `${name} ${valueWords(one)}`).join(', ')
}
