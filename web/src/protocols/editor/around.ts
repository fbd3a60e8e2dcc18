// What a step may take from around it: the point or item of a loop, and the results of earlier steps.
import type { ActionForm } from '../../api/types'
import { gatherIds } from '../text/copying'
import type { Edit } from '../text/edit'
import { isMap, valueAt, type Path } from '../text/path'
import { kindOf } from '../text/steps'
import { spaced, wordsOf } from '../text/titles'
import { innerKey } from '../text/unwrapping'
import { actionOf, type Contracts } from './contracts'
import type { Field } from './fields'
import { hasPoints, loopOf, type Loop } from './loops'

export interface Source {
  /** `x of the point`, `file of Export`. */
  label: string
  /** `point.x`, `steps.export.file`. */
  words: string
  name: string
  kind: Field['kind']
  unit: string
  path: boolean
  /** A step whose result is used needs an id. */
  edits: readonly Edit[]
  /** The action of whose results it is. */
  action: string
}

interface Around {
  name: string
  loop: Loop | null
}

type Known = Pick<Contracts, 'deviceOf'> & Partial<Pick<Contracts, 'tables'>>

/** The loops around a step, the innermost first. */
export function loopsAround(data: unknown, path: Path): Around[] {
  const found: Around[] = []
  for (let length = path.length; length > 0; length--) {
    const step = valueAt(data, path.slice(0, length))
    if (!isMap(step) || kindOf(step) !== 'foreach' || !isMap(step['foreach']) || (length < path.length && path[length] !== 'steps')) continue
    for (const [name, items] of Object.entries(step['foreach'])) found.push({ name, loop: loopOf(items) })
  }
  return found
}

/** Everything in reach at a place: of the loops around it, then of the steps before it, the nearest first. */
export function sourcesAt(data: unknown, path: Path, contracts: Known): Source[] {
  const found = loopsAround(data, path).flatMap((one) => ofLoop(one, contracts.tables ?? []))
  const ids = new Set<string>()
  gatherIds(data, ids)
  for (let length = path.length; length > 0; length--) {
    const at = path[length - 1]
    const list = valueAt(data, path.slice(0, length - 1))
    const together = path[length - 2] === 'parallel' || path[length - 2] === 'any'
    if (typeof at !== 'number' || !Array.isArray(list) || together) continue
    for (let i = at - 1; i >= 0; i--) found.push(...ofStep(data, [...path.slice(0, length - 1), i], contracts, ids))
  }
  return found
}

export function source(words: string, label: string, kind: Field['kind'], unit = ''): Source {
  return { label, words, name: words.split('.').at(-1) ?? '', kind, unit, path: false, edits: [], action: '' }
}

/** What a schema says of a value. */
export function schemaSource(words: string, label: string, part: Record<string, unknown>): Source {
  const types = Array.isArray(part['type']) ? part['type'].map(String) : [String(part['type'])]
  const unit = typeof part['unit'] === 'string' ? part['unit'] : ''
  const kind = types.some((one) => one === 'number' || one === 'integer' || one === 'quantity') || unit !== '' ? 'number' : types.includes('boolean') ? 'truth' : types.includes('string') ? 'text' : 'list'
  return source(words, label, kind, unit)
}

export function paramsOf(data: unknown): Source[] {
  const params = isMap(data) && isMap(data['params']) ? Object.entries(data['params']) : []
  return params.map(([name, part]) => schemaSource(`params.${name}`, `${name} of the parameters`, isMap(part) ? part : {}))
}

function ofLoop({ name, loop }: Around, tables: Contracts['tables']): Source[] {
  const of = `of the ${spaced(name)}`
  if (hasPoints(loop)) return [source(`${name}.x`, `x ${of}`, 'number', 'mm'), source(`${name}.y`, `y ${of}`, 'number', 'mm'), source(`${name}.index`, `number ${of}`, 'number')]
  if (loop?.kind === 'values') return [source(name, spaced(name), 'number', /[a-zµ°%]+/i.exec(loop.slots['to'] ?? '')?.[0] ?? '')]
  if (loop?.kind === 'list') return [source(name, spaced(name), loop.items?.every((one) => typeof one === 'number') === true ? 'number' : 'text')]
  if (loop?.kind === 'table') {
    const { columns = [], kinds = [] } = tables.find((one) => one.name === loop.slots['file']) ?? {}
    return columns.map((column, i) => source(`${name}.${column}`, `${spaced(column)} ${of}`, ...cellOf(kinds[i] ?? '')))
  }
  return []
}

function cellOf(kind: string): [Field['kind'], string] {
  const known: Record<string, Field['kind']> = { integer: 'number', number: 'number', boolean: 'truth', text: 'text' }
  return [known[kind] ?? 'number', kind in known ? '' : kind]
}

function ofStep(data: unknown, path: Path, contracts: Known, ids: ReadonlySet<string>): Source[] {
  const step = valueAt(data, path)
  const kind = kindOf(step)
  if (!isMap(step)) return []
  if (kind === 'parallel' || kind === 'steps') {
    const key = innerKey(kind) ?? ''
    const inner = Array.isArray(step[key]) ? step[key] : []
    return inner.flatMap((_, i) => ofStep(data, [...path, key, i], contracts, ids)).reverse()
  }
  const action = actionOf(contracts as Contracts, data, step['do'])?.action
  const returns = action && isMap(action.returns['properties']) ? action.returns['properties'] : {}
  const id = typeof step['id'] === 'string' ? step['id'] : freeId(action?.name ?? 'step', ids)
  const edits: Edit[] = typeof step['id'] === 'string' ? [] : [{ kind: 'set', path: [...path, 'id'], value: id }]
  return Object.entries(returns).map(([name, part]) => {
    const said: Record<string, unknown> = isMap(part) ? part : {}
    const types = Array.isArray(said['type']) ? said['type'].map(String) : [String(said['type'])]
    const number = types.includes('number') || types.includes('integer')
    return {
      label: `${spaced(name)} of ${wordsOf(step).title}`, words: `steps.${id}.${name}`, name, edits, action: action?.name ?? '',
      kind: number ? 'number' : types.includes('boolean') ? 'truth' : types.includes('array') ? 'list' : 'text',
      unit: typeof said['unit'] === 'string' ? said['unit'] : '', path: said['format'] === 'path',
    }
  })
}

export function freeId(wanted: string, ids: ReadonlySet<string>): string {
  let [id, number] = [wanted, 2]
  while (ids.has(id)) id = `${wanted}_${String(number++)}`
  return id
}

/** Those that a field can hold. */
export function fitting(field: Field, path: boolean, sources: readonly Source[]): Source[] {
  if (field.plain === true || field.kind === 'choice') return []
  return sources.filter((one) => one.kind === field.kind && one.unit === field.unit && (!path || one.path || one.words.indexOf('steps.') < 0))
}

type Part = Record<string, unknown>

/** The argument that a person would most likely write here; null if there is no telling. */
export function likely(action: ActionForm, name: string, part: Part, sources: readonly Source[]): Source | null {
  const path = part['format'] === 'path'
  const made = isMap(action.returns['properties']) && Object.hasOwn(action.returns['properties'], name)
  if (path && made) return null
  const others = sources.filter((one) => one.action !== action.name && one.action !== '')
  if (path) return others.find((one) => one.path) ?? null
  const unit = typeof part['unit'] === 'string' ? part['unit'] : ''
  const types = part['type'] === 'number' || part['type'] === 'integer' ? 'number' : part['type'] === 'string' ? 'text' : ''
  if (unit === 'mm' && (name === 'x' || name === 'y')) return sources.find((one) => one.action === '' && one.name === name && one.unit === unit) ?? null
  return others.find((one) => one.kind === types && one.unit === unit && (one.name === name || one.name === `${name}_id`)) ?? null
}

/** A file name that is another one in each iteration. */
export function fileFor(action: string, name: string, around: readonly Around[]): string {
  const tags = [...around].reverse().map(({ name: item, loop }) => {
    if (loop?.kind === 'grid') return `\${{ ${item}.ix }}_\${{ ${item}.iy }}`
    return hasPoints(loop) ? `\${{ ${item}.index }}` : loop?.kind === 'list' || loop?.kind === 'values' ? `\${{ ${item} }}` : ''
  })
  return `${[name === 'file' ? action : name, ...tags.filter(Boolean)].join('_')}.${/image|depth|picture/.test(name) ? 'png' : 'csv'}`
}
