// The kinds of steps of the language, and the keys under which a step holds other steps.
import { isMap, type Path } from './path'

/** The first of these keys decides the kind of a step, as in the engine. */
export const STEP_KINDS = [
  'do', 'parallel', 'any', 'foreach', 'repeat', 'while', 'if', 'use', 'steps',
  'confirm', 'ask', 'wait', 'set', 'require', 'log', 'notify', 'fail',
] as const
export type StepKind = (typeof STEP_KINDS)[number]

export const STEP_LISTS = ['steps', 'parallel', 'any', 'then', 'else', 'fallback'] as const
export const SECTIONS = ['steps', 'on_resume', 'finally'] as const
/** Lists that are left out if empty. */
export const OPTIONAL_LISTS: ReadonlySet<string> = new Set(['on_resume', 'finally', 'else', 'fallback'])

export function kindOf(step: unknown): StepKind | null {
  return isMap(step) ? (STEP_KINDS.find((kind) => Object.hasOwn(step, kind)) ?? null) : null
}

/** The order in which a protocol and a step are written; keys not named here come before `steps`. */
const TOP_ORDER = ['labrun', 'name', 'summary', 'params', 'devices', 'defaults', 'steps', 'on_resume', 'finally', 'outputs']
const STEP_ORDER = [
  'id', 'name', 'when', 'do', 'parallel', 'any', 'foreach', 'repeat', 'while', 'if', 'use', 'confirm', 'ask', 'wait', 'set',
  'require', 'log', 'notify', 'fail', 'picture', 'with', 'devices', 'choices', 'max', 'key', 'at_once', 'order', 'reserve', 'watch', 'mode', 'timeout', 'retry', 'on_failure', 'on_unknown',
  'on_error', 'keep_going', 'steps', 'then', 'else', 'fallback', 'collect',
]

/** Where a new key goes among the existing ones: the index of the one it precedes. */
export function placeOfKey(path: Path, keys: readonly (string | null)[], key: string): number {
  const last = path.at(-1)
  const order = path.length === 0 ? TOP_ORDER : typeof last === 'number' ? STEP_ORDER : []
  const rank = order.indexOf(key)
  if (rank < 0) return keys.length
  const later = keys.findIndex((other) => other !== null && order.indexOf(other) > rank)
  return later < 0 ? keys.length : later
}
