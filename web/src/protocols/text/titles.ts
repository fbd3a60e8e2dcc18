// A readable title for a step, with the numbers that matter.
import { callOf, innerOf, unquoted } from './calls'
import { isMap } from './path'
import { kindOf, type StepKind } from './steps'

export interface Words {
  title: string
  detail: string
}

const LONGEST = 60

export function wordsOf(step: unknown): Words {
  const kind = kindOf(step)
  if (kind === null || !isMap(step)) return { title: Array.isArray(step) ? 'Steps in order' : 'Not a step', detail: shown(step) }
  const { title, detail } = OF_KIND[kind](step)
  const named = typeof step['name'] === 'string' && step['name'] !== ''
  const parts = [named ? title : '', detail, ...ladder(step)]
  return { title: named ? upper(shown(step['name'])) : title, detail: parts.filter((part) => part !== '').join(' · ') }
}

const OF_KIND: Record<StepKind, (step: Record<string, unknown>) => Words> = {
  do: (step) => {
    const [role = '', action = ''] = String(step['do']).split('.')
    return { title: action === '' ? shown(step['do']) : upper(spaced(action)), detail: [action === '' ? '' : role, argumentsOf(step['with'])].filter(Boolean).join(' · ') }
  },
  parallel: (step) => ({ title: 'At the same time', detail: counted(step['parallel']) }),
  any: (step) => ({ title: 'Until one succeeds', detail: counted(step['any']) }),
  foreach: (step) => {
    const [name, items] = Object.entries(isMap(step['foreach']) ? step['foreach'] : {})[0] ?? ['item', null]
    return { title: `For each ${spaced(name)}`, detail: Array.isArray(items) ? counted(items, 'item') : itemsWords(items) }
  },
  repeat: (step) => ({ title: `Repeat ${shown(step['repeat'])} times`, detail: '' }),
  while: (step) => ({ title: `While ${shown(step['while'])}`, detail: step['max'] == null ? '' : `${shown(step['max'])} times at most` }),
  if: (step) => ({ title: `If ${shown(step['if'])}`, detail: '' }),
  use: (step) => ({ title: `Use ${shown(step['use']).replace(/^\.\//, '')}`, detail: argumentsOf(step['with']) }),
  steps: (step) => ({ title: 'Steps in order', detail: counted(step['steps']) }),
  confirm: (step) => ({ title: 'Ask to confirm', detail: `“${shown(step['confirm'])}”` }),
  ask: (step) => ({ title: 'Ask', detail: `“${shown(step['ask'])}” ${Array.isArray(step['choices']) ? step['choices'].map(shown).join(' / ') : ''}` }),
  wait: (step) => ({ title: isMap(step['wait']) ? `Wait until ${shown(step['wait']['until'])}` : `Wait ${shown(step['wait'])}`, detail: '' }),
  set: (step) => ({ title: `Set ${Object.keys(isMap(step['set']) ? step['set'] : {}).join(', ')}`, detail: '' }),
  require: (step) => ({ title: `Require ${shown(step['require'])}`, detail: '' }),
  log: (step) => ({ title: 'Write to the log', detail: `“${shown(step['log'])}”` }),
  notify: (step) => ({ title: 'Tell people', detail: `“${shown(step['notify'])}”` }),
  fail: (step) => ({ title: 'Fail', detail: `“${shown(step['fail'])}”` }),
}

/** `a grid inside steps.find.outline`, `rows of samples.csv`, `0 mm to 10 mm by 2 mm`; anything else as it is written. */
function itemsWords(items: unknown): string {
  const call = callOf(innerOf(items) ?? '')
  const [first = '', second = '', third = ''] = call?.args.map(({ text }) => shown(`\${{ ${text} }}`)) ?? []
  const file = (text: string): string => unquoted(callOf(text)?.name === 'csv' ? (callOf(text)?.args[0]?.text ?? '') : text) ?? text
  if (call?.name === 'csv') return `rows of ${file(first)}`
  if (call?.name === 'inside' && second !== '') return `${callOf(call.args[0]?.text ?? '')?.name === 'grid' ? 'a grid' : first} inside ${file(second)}`
  return call?.name === 'span' && third !== '' ? `${first} to ${second} by ${third}` : shown(items)
}

/** What happens if it fails. */
function ladder(step: Record<string, unknown>): string[] {
  const { retry, timeout, mode, when, on_error: onError, keep_going: keepGoing } = step
  const attempts = isMap(retry) ? retry['attempts'] : retry
  return [
    when == null ? '' : `only if ${shown(when)}`,
    attempts == null ? '' : `tried ${shown(attempts)}×`,
    timeout == null ? '' : `${shown(timeout)} at most`,
    step['at_once'] == null ? '' : `${shown(step['at_once'])} at once${step['order'] === 'shortest' ? ', in the shortest order' : ''}`,
    Array.isArray(step['reserve']) ? `keeps ${step['reserve'].map(shown).join(', ')} for itself` : '',
    Array.isArray(step['watch']) ? 'watched' : '',
    mode === 'background' ? 'in the background' : '',
    keepGoing === true ? 'any may fail' : '',
    isMap(keepGoing) && keepGoing['max_failed'] !== undefined ? `${shown(keepGoing['max_failed'])} may fail` : '',
    isMap(keepGoing) && keepGoing['in_a_row'] !== undefined ? `${shown(keepGoing['in_a_row'])} in a row may fail` : '',
    onError === 'continue' ? 'continues if it fails' : onError === 'pause' ? 'pauses if it fails' : '',
  ]
}

function argumentsOf(value: unknown): string {
  if (!isMap(value)) return ''
  return cut(Object.entries(value).map(([name, one]) => `${spaced(name)} ${String(one).includes('${{') ? '= ' : ''}${shown(one)}`).join(', '))
}

/** A value for a reader: an expression without its braces. */
export function shown(value: unknown): string {
  if (value == null) return '–'
  if (Array.isArray(value)) return cut(value.map(shown).join(', '))
  if (isMap(value)) return cut(Object.entries(value).map(([key, one]) => `${key} ${shown(one)}`).join(', '))
  const text = String(value as string | number | boolean).replace(/\$\{\{\s*(.*?)\s*\}\}/gs, (_, inner: string) => inner.replace(/\bparams\./g, ''))
  return cut(text.replace(/\s+/g, ' '))
}

function cut(text: string): string {
  return text.length > LONGEST ? `${text.slice(0, LONGEST - 1)}…` : text
}

function counted(list: unknown, word = 'step'): string {
  const count = Array.isArray(list) ? list.length : 0
  return `${String(count)} ${word}${count === 1 ? '' : 's'}`
}

export function spaced(name: string): string {
  return name.replaceAll('_', ' ')
}

export function upper(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1)
}
