// Values written as YAML: plain where unambiguous, otherwise quoted.
import { isMap } from './path'
import type { Quote } from './place'

export interface Style {
  /** Between brackets, where commas and braces mean something. */
  flow: boolean
  json: boolean
  quote?: Quote
}

/** Text that every YAML 1.1 or 1.2 reader takes as text. */
const PLAIN = /^[\p{L}\p{N}_$./(+<][^\p{C}\u2028\u2029\ufeff]*$/u
const NUMBER_OR_DATE = /^[-+.]?\d[\d_.,:eExXoTZ+-]*[a-fA-F\d]*$|^[-+]?\.(inf|nan)$|^\d{4}-\d\d?-\d\d?/i
const WORD = /^(true|false|yes|no|on|off|y|n|null|~|)$/i
const WIDE = 88

/** A number, truth value, null or text; non-finite numbers are refused. */
export function writeScalar(value: unknown, style: Style): string {
  if (typeof value === 'string') return writeText(value, style)
  if (typeof value === 'number' && !Number.isFinite(value)) throw new RangeError(`a protocol cannot hold the number ${value}`)
  return value == null ? 'null' : String(value as number | boolean | bigint)
}

function writeText(text: string, { flow, json, quote }: Style): string {
  if (json || quote === 'double') return JSON.stringify(text)
  if (quote === 'single' && /^[\p{L}\p{N}\p{P}\p{S} ]*$/u.test(text)) return `'${text.replaceAll("'", "''")}'`
  return isPlain(text, flow) ? text : JSON.stringify(text)
}

/** Whether a text can be written without quotes. */
export function isPlain(text: string, flow: boolean): boolean {
  if (!PLAIN.test(text) || NUMBER_OR_DATE.test(text) || WORD.test(text)) return false
  if (text.endsWith(' ') || text.endsWith(':') || text.includes(': ') || text.includes(' #')) return false
  return !flow || !/[,[\]{}]/.test(text)
}

/** The name of a pair: `x` and `y` are coordinates, to every reader of protocols. */
export function writeKey(key: string, style: Style): string {
  return style.json || !/^[xyn]$/i.test(key) ? writeScalar(key, style) : key
}

/** On one line, between brackets. */
export function writeFlow(value: unknown, json: boolean): string {
  if (Array.isArray(value)) return `[${value.map((item) => writeFlow(item, json)).join(', ')}]`
  if (!isMap(value)) return writeScalar(value, { flow: true, json })
  const pairs = Object.entries(value).filter(([, member]) => member !== undefined)
  return `{${pairs.map(([key, member]) => `${writeKey(key, { flow: true, json })}: ${writeFlow(member, json)}`).join(', ')}}`
}

/** The value of a pair, with the white space after the colon. */
export function writeValue(value: unknown, indent: number, json: boolean): string {
  if (json || !holdsMuch(value, indent)) {
    const simple = !Array.isArray(value) && !isMap(value)
    return ` ${simple ? writeScalar(value, { flow: false, json }) : writeFlow(value, json)}`
  }
  const lines = Array.isArray(value) ? writeItems(value, indent + 2) : writePairs(value as Record<string, unknown>, indent + 2)
  return `\n${' '.repeat(indent + 2)}${lines}`
}

/** The items of a block list whose first dash is already at `indent`. */
export function writeItems(items: readonly unknown[], indent: number): string {
  return items.map((item) => `- ${writeItem(item, indent)}`).join(`\n${' '.repeat(indent)}`)
}

function writeItem(item: unknown, indent: number): string {
  if (isMap(item) && holdsMuch(item, indent + 2)) return writePairs(item, indent + 2)
  if (isMap(item) && Object.keys(item).length === 1) return writePairs(item, indent + 2)
  return Array.isArray(item) || isMap(item) ? writeFlow(item, false) : writeScalar(item, { flow: false, json: false })
}

/** The pairs of a block map whose first key is already at `indent`. */
export function writePairs(map: Record<string, unknown>, indent: number): string {
  return Object.entries(map)
    .filter(([, value]) => value !== undefined)
    .map(([key, value]) => `${writeKey(key, { flow: false, json: false })}:${writeValue(value, indent, false)}`)
    .join(`\n${' '.repeat(indent)}`)
}

/** Steps within, or more than one line holds. */
function holdsMuch(value: unknown, indent: number): boolean {
  if (!Array.isArray(value) && !isMap(value)) return false
  if (Object.keys(value).length === 0) return false
  if (Array.isArray(value) && value.some(isMap)) return true
  if (isMap(value) && Object.values(value).some((member) => holdsMuch(member, 0))) return true
  return indent + writeFlow(value, false).length > WIDE
}
