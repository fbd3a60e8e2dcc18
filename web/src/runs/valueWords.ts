// A value out of the journal as a person reads it: quantities with their unit.
import '../ui/Figures' // copied with all digits
import { exact, figures } from '../ui/format'

export function valueWords(value: unknown, digits: (value: number) => string = figures): string {
  const words = (one: unknown): string => valueWords(one, digits)
  if (value === null || value === undefined) return '–'
  if (typeof value === 'number') return digits(value)
  if (Array.isArray(value)) return value.length > 8 ? `${value.length} values` : value.map(words).join(', ')
  if (typeof value !== 'object') return String(value)
  const quantity: unknown = (value as Record<string, unknown>)['$quantity']
  if (Array.isArray(quantity)) return `${words(quantity[0])} ${String(quantity[1]).replaceAll(' / ', '/')}`
  if ('$moment' in value) return String(value.$moment)
  return Object.entries(value).map(([name, one]) => `${name} ${words(one)}`).join(', ')
}

/** With every digit, for whoever points at it. */
export const allOf = (value: unknown): string => valueWords(value, exact)
