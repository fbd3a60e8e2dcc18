// A list as a person types it: items divided by commas, or by semicolons where there is one.
import { counted, isNumber, pointed } from './format'

/** A number with a decimal comma, with or without a unit: `0,5`, `1,5 mm/min`; not `1,2-dichloroethane`. */
const DECIMAL = /^[-+−]?\d*,\d+(?:e[-+]?\d+)?(?:\s*[A-Za-zµμ°%Ω][\wµμ°%Ω/*^·]*)?$/i

/**
 * `007, "B, C", 3`: a comma before a space divides, and so does one that is no decimal comma. `0,5` and `0,5; 1,5` are one
 * number and two; `0,5,1,5` is four, which is why `listWords` says at once what was understood.
 */
export function listOf(written: string, texts = false): unknown[] {
  const text = written.trim().replace(/^\[|\]$/g, '')
  const parts = text.match(/(?:"(?:[^"\\]|\\.)*"|[^;])+/g) ?? []
  const divided = parts.length > 1 || /;\s*$/.test(text)
  const items = divided ? parts : (text.match(/(?:"(?:[^"\\]|\\.)*"|[^,]|,(?!\s|$))+/g) ?? []).flatMap((one) => (DECIMAL.test(one.trim()) ? [one] : (one.match(/(?:"(?:[^"\\]|\\.)*"|[^,])+/g) ?? [])))
  return items.map((one) => one.trim()).filter(Boolean).map((one) => itemOf(one, texts))
}

/** The same as one types it. */
export function listText(items: readonly unknown[], texts = false): string {
  return items.map((one) => itemText(one, texts)).join(', ')
}

/** `2 items: 0.5 · "B, C"`. */
export function listWords(items: readonly unknown[], texts = false): string {
  return `${counted(items.length, 'item')}${items.length ? ': ' : ''}${items.map((one) => itemText(one, texts)).join(' · ')}`
}

/** `007`, `1E5` and twenty digits name something: as numbers they would be something else. */
export function itemOf(text: string, texts = false): unknown {
  if (/^".*"$/.test(text)) {
    try {
      return JSON.parse(text)
    } catch {
      return text
    }
  }
  const plain = pointed(text)
  if (!texts && isNumber(plain) && !/^[-+]?0\d|\de\d|\d{16}/i.test(plain)) return Number(plain)
  return !texts && DECIMAL.test(text) ? plain : text
}

/** In quotes where it would be read as something else. */
export function itemText(item: unknown, texts = false, dividers = /[",;[\]]/): string {
  const text = String(item)
  return typeof item === 'string' && (text === '' || text !== text.trim() || dividers.test(text) || itemOf(text, texts) !== text) ? JSON.stringify(text) : text
}
