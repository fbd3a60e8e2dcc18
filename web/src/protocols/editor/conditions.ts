// A condition as a form: `${{ status.oven.temperature > 950 degC and not status.leak.wet }}`, and how it is written.
import { isNumber, pointed } from '../../ui/format'
import { isMap, type Path } from '../text/path'
import { paramsOf, schemaSource, source, sourcesAt, type Source } from './around'
import { innerOf, unquoted } from '../text/calls'
import type { Contracts } from './contracts'
import type { Field } from './fields'
import { namesIn } from './names'

export type Comparison = 'is' | 'not' | '<' | '<=' | '>' | '>=' | '==' | '!='

export interface Clause {
  /** `status.oven.temperature`, `turn`. */
  left: string
  comparison: Comparison
  /** As it stands in the expression; empty with `is` and `not`. */
  right: string
}

export interface Condition {
  join: 'and' | 'or'
  clauses: readonly Clause[]
}

/** In words, for a truth, a text and a number. */
export const TRUTH: [Comparison, string][] = [['is', 'is true'], ['not', 'is not true']]
export const EQUAL: [Comparison, string][] = [['==', 'is'], ['!=', 'is not']]
export const ORDER: [Comparison, string][] = [['>', 'is more than'], ['>=', 'is at least'], ['<', 'is less than'], ['<=', 'is at most'], ...EQUAL]

const NAME = String.raw`[A-Za-z_]\w*(?:\.[A-Za-z_]\w*|\[\d+\])*`
const VALUE = String.raw`-?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?(?: [A-Za-zµ°Ω%]+(?:[/*][A-Za-z]+)?)?|'[^'\\]*'|"[^"\\]*"|${NAME}`
const CLAUSE = new RegExp(`^(?:(not) )?(${NAME})(?: (<=|>=|==|!=|<|>) (${VALUE}))?$`)

/** Null where it is more than clauses that are all joined by `and`, or all by `or`. */
export function conditionOf(value: unknown): Condition | null {
  const text = innerOf(value)
  if (text === null) return null
  const bare = text.replace(/'[^']*'|"[^"]*"/g, (quoted) => '_'.repeat(quoted.length))
  const join = bare.includes(' or ') ? 'or' : 'and'
  let at = 0
  const clauses = bare.split(` ${join} `).map(({ length }) => {
    const clause = clauseOf(text.slice(at, at + length))
    at += length + join.length + 2
    return clause
  })
  const found: Condition = { join, clauses: clauses.filter((one) => one !== null) }
  return found.clauses.length === clauses.length && writtenCondition(found) === `\${{ ${text} }}` ? found : null
}

function clauseOf(text: string): Clause | null {
  const [, not, left, comparison, right] = CLAUSE.exec(text) ?? []
  if (left === undefined || /^(?:true|false|null|not)$/i.test(left) || (not !== undefined && right !== undefined)) return null
  return { left, comparison: (comparison as Comparison | undefined) ?? (not === undefined ? 'is' : 'not'), right: right ?? '' }
}

export function writtenCondition({ join, clauses }: Condition): string {
  const words = clauses.map(({ left, comparison, right }) => (comparison === 'is' ? left : comparison === 'not' ? `not ${left}` : `${left} ${comparison} ${right}`))
  return `\${{ ${words.join(` ${join} `)} }}`
}

/** What is typed beside a comparison, as an expression has it: with its unit, or in quotes. */
export function writtenRight(typed: string, source: Pick<Source, 'kind' | 'unit'> | undefined): string {
  const text = typed.trim()
  if (source?.kind === 'text') return /['\\]/.test(text) ? JSON.stringify(text) : `'${text}'`
  const given = pointed(text) || '0'
  return isNumber(given) && source && source.unit !== '' ? `${given} ${source.unit}` : given
}

/** How the right side is shown in a field: a text without its quotes. */
export function shownRight(right: string): string {
  return unquoted(right) ?? right
}

export function comparisonsOf(kind: Field['kind'] | undefined): [Comparison, string][] {
  if (kind === 'truth') return TRUTH
  return kind === 'text' || kind === 'choice' ? EQUAL : kind === 'number' ? ORDER : [...ORDER, ...TRUTH]
}

/** What a condition may look at: devices' status where it is looked at while steps run, results, loops, names, parameters. */
export function lookedAt(data: unknown, path: Path, contracts: Pick<Contracts, 'deviceOf'>, watching: boolean): Source[] {
  const known = sourcesAt(data, path, contracts)
  const names = namesIn(data)
    .filter(({ name, detail }) => detail === 'set by a step' || name === 'run.simulated')
    .map(({ name }): Source => source(name, name === 'run.simulated' ? 'this run is simulated' : name, name === 'run.simulated' ? 'truth' : 'list', ''))
  return [...(watching ? statusOf(data, contracts) : []), ...known, ...names, ...paramsOf(data)]
}

/** Every status field of the devices of the protocol. */
function statusOf(data: unknown, contracts: Pick<Contracts, 'deviceOf'>): Source[] {
  const devices = isMap(data) && isMap(data['devices']) ? Object.entries(data['devices']) : []
  return devices.flatMap(([role, contract]) => {
    const schema = typeof contract === 'string' ? contracts.deviceOf(contract, role)?.status_schema : undefined
    const fields = schema && isMap(schema['properties']) ? Object.entries(schema['properties']) : []
    return fields.map(([name, part]) => schemaSource(`status.${role}.${name}`, `${name.replaceAll('_', ' ')} of ${role}`, isMap(part) ? part : {}))
  })
}
