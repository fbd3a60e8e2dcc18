// Parameters of a protocol as fields: what is typed, what it must be, what is sent.
import type { Received } from '../../api/types'
import { isNumber, pointed, typedNumber } from '../../ui/format'
import { listOf, listText, listWords } from '../../ui/lists'

export type ParamForm = Received<'ParamForm'>

/** The initial text of a field: the default as typed, without the unit shown beside it. */
export function shownDefault(param: ParamForm): string {
  return shown(param, param.default)
}

/** Any value of a parameter as its field shows it. */
export function shown(param: ParamForm, value: unknown): string {
  if (value === null || value === undefined) return ''
  if (typeof value === 'string') return param.type === 'quantity' ? withoutUnit(value, param.unit) : value
  if (Array.isArray(value) && value.every((one) => typeof one !== 'object')) return listText(value)
  if (typeof value === 'object') return JSON.stringify(value)
  return String(value)
}

function withoutUnit(text: string, unit: string | null): string {
  const suffix = unit === null ? '' : ` ${unit}`
  return suffix && text.endsWith(suffix) ? text.slice(0, -suffix.length) : text
}

/** What is sent for what was typed: a bare number gets its unit, a decimal comma becomes a point. */
export function sent(param: ParamForm, typed: string): unknown {
  const text = typed.trim()
  if (param.type === 'string') return typed
  if (param.type === 'boolean') return text === 'true'
  if (param.type === 'array') return NESTED.test(text) ? text : listOf(text)
  const plain = pointed(text)
  if (param.type === 'quantity') return isNumber(plain) && param.unit ? `${plain} ${param.unit}` : plain
  return isNumber(plain) ? Number(plain) : text
}

/** What the server reads: lists of lists, maps, and quotes of YAML. */
const NESTED = /^.+[[{]|[{']/

/** What is understood of a list that was typed; empty for anything else. */
export function understood(param: ParamForm, typed: string): string {
  const value = param.type === 'array' && typed.trim() !== '' && typed !== shownDefault(param) ? sent(param, typed) : null
  return Array.isArray(value) ? listWords(value) : ''
}

/** The error in the typed text; empty if the server is to judge. */
export function fault(param: ParamForm, typed: string): string {
  const text = typed.trim()
  if (text === '') return param.required ? 'needed' : ''
  if (param.type === 'string')
    return param.pattern && !new RegExp(param.pattern, 'u').test(typed) ? patternWords(param.pattern) : ''
  if (param.type !== 'quantity' && param.type !== 'number' && param.type !== 'integer') return ''
  const number = typedNumber(text)
  if (number === null) return param.type === 'quantity' ? '' : 'enter a number'
  if (param.type === 'integer' && !Number.isInteger(number)) return 'enter a whole number'
  const [low, high] = [bound(param, param.minimum), bound(param, param.maximum)]
  if (low !== null && number < low) return `at least ${low}${unitWords(param)}`
  if (high !== null && number > high) return `at most ${high}${unitWords(param)}`
  return ''
}

/** Most patterns of labs say what a file may be called. */
function patternWords(pattern: string): string {
  const most = /^\^\[A-Za-z0-9_-\]\{1,(\d+)\}\$$/.exec(pattern)?.[1]
  return most ? `only letters A–Z, digits, _ and -, at most ${most}` : `must match ${pattern}`
}

/** The range beside a field: `0.1–730 mm`. */
export function rangeWords(param: ParamForm): string {
  const [low, high] = [shown(param, param.minimum), shown(param, param.maximum)]
  if (low && high) return `${low}–${high}${unitWords(param)}`
  if (low) return `at least ${low}${unitWords(param)}`
  return high ? `at most ${high}${unitWords(param)}` : ''
}

function unitWords(param: ParamForm): string {
  return param.unit ? ` ${param.unit}` : ''
}

function bound(param: ParamForm, value: unknown): number | null {
  return typedNumber(shown(param, value))
}

/** Only what differs from the defaults is sent; an empty field is left at its default. */
export function chosen(params: readonly ParamForm[], typed: Readonly<Record<string, string>>): Record<string, unknown> {
  const found: Record<string, unknown> = {}
  for (const param of params) {
    const text = typed[param.name]
    if (text === undefined || text === '' || text === shownDefault(param)) continue
    found[param.name] = sent(param, text)
  }
  return found
}
