// The form fields of each kind of step, beside the parameters of an action.
import type { StepKind } from '../text/steps'
import type { Field } from './fields'

export interface StepField extends Field {
  label: string
  /** Shown only where a person asks for more. */
  rare?: boolean
}

function field(name: string, label: string, kind: Field['kind'] = 'text', about = '', more: Partial<StepField> = {}): StepField {
  return { name, label, kind, about, unit: '', choices: [], required: false, placeholder: '', ...more }
}

const NEEDED = { required: true }
const PLAIN = { plain: true }
const RARE = { rare: true }

/** The keys that say what the step does. */
export const OF_KIND: Record<StepKind, StepField[]> = {
  do: [],
  parallel: [field('on_failure', 'When one fails', 'choice', 'What happens to the others', { choices: ['finish', 'cancel'], ...PLAIN })],
  any: [],
  foreach: [
    field('key', 'Key', 'text', 'What permanently identifies an iteration, such as ${{ point.index }}', RARE),
    field('at_once', 'At once', 'number', 'How many may run at the same time', { placeholder: '1', ...RARE }),
    field('order', 'Order of those at once', 'choice', 'As listed, or so that all take the least time', { choices: ['listed', 'shortest'], ...PLAIN, ...RARE }),
  ],
  repeat: [field('repeat', 'How often', 'number', '', NEEDED)],
  while: [field('max', 'At most', 'number', 'How often at most; then the step fails')],
  if: [],
  use: [field('use', 'Protocol', 'text', 'Its file, relative to this one', { ...NEEDED, ...PLAIN })],
  steps: [field('reserve', 'Keeps for itself', 'list', 'Devices that no other steps use meanwhile, separated by commas or semicolons', { texts: true, ...PLAIN, ...RARE })],
  confirm: [field('confirm', 'Text', 'text', 'A person confirms before anything else happens', NEEDED)],
  ask: [field('ask', 'Question', 'text', '', NEEDED), field('choices', 'Choices', 'list', 'Separated by commas or semicolons', { texts: true, ...NEEDED, ...PLAIN })],
  wait: [field('wait', 'How long', 'number', 'Such as 5 s or 2 min', { unit: 's', ...NEEDED })],
  set: [],
  require: [],
  log: [field('log', 'Text', 'text', 'A line on the screen and in the journal', NEEDED)],
  notify: [
    field('notify', 'Text', 'text', 'Goes to the people whom the lab names', NEEDED),
    field('picture', 'Picture', 'text', 'A file in the folder of the run that goes with it', PLAIN),
  ],
  fail: [field('fail', 'Text', 'text', 'The step fails with this message', NEEDED)],
}

/** What decides: a condition, chosen or written. */
export const CONDITION: Partial<Record<StepKind, StepField>> = {
  while: field('while', 'As long as', 'text', 'An expression', NEEDED),
  if: field('if', 'If', 'text', 'An expression', NEEDED),
  require: field('require', 'What must be true', 'text', 'The run fails here unless it is', NEEDED),
}
export const WATCHED = field('when', 'What is watched', 'text', 'An expression', NEEDED)
export const EVERY = field('every', 'Looked at every', 'number', 'Such as 5 s', { unit: 's', placeholder: 'change', ...PLAIN })
export const STALE = field('stale', 'Too old after', 'number', 'Such as 10 s', { unit: 's', placeholder: '3 × as long, 5 s or more', ...PLAIN })

/** Fields of every step. */
export const WHEN = field('when', 'Only if', 'text', 'An expression; if it is false, the step is skipped')
export const ID = field('id', 'Id', 'text', 'Other steps refer to its result as steps.ID', PLAIN)
export const NAME = field('name', 'Name', 'text', 'Shown instead of what it does', PLAIN)
export const TIMEOUT = field('timeout', 'At most', 'number', 'Such as 30 s; after that the step fails', { unit: 's', placeholder: 'no limit', ...PLAIN })
export const MODE = field('mode', 'Mode', 'choice', 'background: the next step starts without waiting', { choices: ['background'], ...PLAIN })
export const UNKNOWN = field('on_unknown', 'If it is unknown whether it happened', 'choice', '', { choices: ['probe', 'ask', 'skip', 'repeat'], ...PLAIN })
export const ATTEMPTS = field('attempts', 'Attempts in total', 'number', '', { placeholder: '1', ...PLAIN })
export const WAIT = field('wait', 'Wait between', 'number', 'Such as 2 s', { unit: 's', placeholder: '0 s', ...PLAIN })
export const MAX_FAILED = field('max_failed', 'May fail', 'number', 'How many may fail before the loop fails', { placeholder: 'any', ...PLAIN })
export const IN_A_ROW = field('in_a_row', 'In a row', 'number', 'How many in a row may fail before the loop fails', { placeholder: 'any', ...PLAIN })

/** Keys shown elsewhere: in the outline, or in their own part of the form. */
export const ELSEWHERE = new Set([
  'do', 'with', 'steps', 'parallel', 'any', 'then', 'else', 'fallback', 'foreach', 'set', 'devices', 'collect', 'retry', 'on_error', 'keep_going',
  'when', 'id', 'name', 'timeout', 'mode', 'on_unknown', 'choices', 'max', 'key', 'on_failure', 'watch', 'while', 'if', 'require',
])
export const LOOPS: ReadonlySet<string> = new Set(['foreach', 'repeat', 'while'])
