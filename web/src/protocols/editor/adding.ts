// What "Add step" offers: the actions of the available devices, and the structures.
import type { Received } from '../../api/types'
import type { ActionForm, DeviceDetail } from '../../api/types'
import { lastOfAll, type Edit } from '../text/edit'
import { isMap, valueAt, type Path } from '../text/path'
import { spaced } from '../text/titles'
import { gatherIds } from '../text/copying'
import { askWhatNow } from '../text/wrapping'
import { fileFor, freeId, likely, loopsAround, sourcesAt, type Source } from './around'
import type { Contracts } from './contracts'
import { fresh, keyOf, writtenLoop } from './loops'
import { placeAfter } from './moves'

export interface Offer {
  key: string
  name: string
  about: string
  mark: string
  /** The edits that add it after the row at `path`, or inside it. */
  edits(data: unknown, path: Path, inside: boolean): Edit[]
}

type Roles = readonly Received<'RoleForm'>[]

/** Those of devices that the protocol uses first; by which the engine asks whether something happened, last. */
export function actionOffers(contracts: Pick<Contracts, 'devices' | 'reach' | 'deviceOf'>, roles: Roles): Offer[] {
  const { devices, reach } = contracts
  const late = ({ key }: Offer): number => (/\.last_/.test(key) ? 2 : 0) + (roles.some((one) => key.startsWith(`${one.device ?? ''}.`)) ? 0 : 1)
  const offers = devices.flatMap((device) =>
    device.actions.map((action): Offer => {
      const online = (reach.get(device.name) ?? device.reach) === 'online'
      return {
        key: `${device.name}.${action.name}`,
        name: `${device.name}: ${spaced(action.name)}`,
        about: action.summary,
        mark: [action.danger && action.danger !== 'motion' ? `☀ ${action.danger}` : '', online ? '' : 'offline'].filter(Boolean).join(' · '),
        edits: (data, path, inside) => {
          const { role, edits } = roleFor(data, device, roles)
          const { list, index } = placeAfter(data, path, inside)
          const given = withOf(action, data, [...list, index], contracts)
          return [...edits, ...given.edits, insertion(data, path, inside, { do: `${role}.${action.name}`, ...given.with })]
        },
      }
    }),
  )
  return offers.sort((a, b) => late(a) - late(b))
}

/** The role that a device plays in the protocol; a new one if it plays none. */
export function roleFor(data: unknown, device: { name: string; contract: string }, roles: Roles): { role: string; edits: Edit[] } {
  const given = valueAt(data, ['devices'])
  const all = isMap(given) ? given : {}
  const bound = roles.find((one) => one.device === device.name && all[one.role] === device.contract)?.role
  const role = bound ?? (all[device.name] === device.contract ? device.name : undefined)
  if (role !== undefined) return { role, edits: [] }
  let name = device.name.replace(/\W/g, '_')
  while (Object.hasOwn(all, name)) name += '_2'
  return { role: name, edits: [{ kind: 'set', path: ['devices', name], value: device.contract }] }
}

function insertion(data: unknown, path: Path, inside: boolean, step: unknown): Edit {
  const { list, index } = placeAfter(data, path, inside)
  return valueAt(data, list) === undefined ? { kind: 'set', path: list, value: [step] } : { kind: 'insert', path: list, index, values: [step] }
}

/** The required parameters: taken from around the step where that is likely, else the smallest valid values. */
function withOf(action: ActionForm, data: unknown, at: Path, contracts: Pick<Contracts, 'deviceOf'>): { with: { with?: Record<string, unknown> }; edits: Edit[] } {
  const properties = isMap(action.params['properties']) ? action.params['properties'] : {}
  const required = Array.isArray(action.params['required']) ? action.params['required'].map(String) : []
  const least = Number(action.params['minProperties'] ?? 0)
  const sources = sourcesAt(data, at, contracts)
  const taken = new Map<string, Source>()
  for (const [name, part] of Object.entries(properties)) {
    const source = likely(action, name, isMap(part) ? part : {}, sources)
    if (source && (source.action === '' || required.includes(name))) taken.set(name, source)
  }
  const needed = required.length > 0 ? required : taken.size > 0 ? [] : Object.keys(properties).slice(0, least)
  const names = Object.keys(properties).filter((name) => needed.includes(name) || taken.has(name))
  if (names.length === 0) return { with: {}, edits: [] }
  const around = loopsAround(data, at)
  const given = names.map((name): [string, unknown] => {
    const source = taken.get(name)
    const part = isMap(properties[name]) ? properties[name] : {}
    if (source) return [name, `\${{ ${source.words} }}`]
    return [name, part['format'] === 'path' && part['default'] === undefined ? fileFor(action.name, name, around) : firstValue(name, part)]
  })
  return { with: { with: Object.fromEntries(given) }, edits: [...taken.values()].flatMap((one) => one.edits) }
}

function firstValue(name: string, part: Record<string, unknown>): unknown {
  if (part['default'] !== undefined) return part['default']
  if (Array.isArray(part['enum'])) return part['enum'][0]
  if (part['type'] === 'boolean') return false
  if (part['type'] === 'array') return []
  const least = typeof part['minimum'] === 'number' ? part['minimum'] : 0
  if (part['type'] === 'number') return typeof part['unit'] === 'string' ? `${String(least)} ${part['unit']}` : least
  if (part['type'] === 'integer') return least
  return name
}

const PAUSE = { wait: '1 s' }

/** The structures, each with a placeholder step. */
export function structureOffers(devices: readonly DeviceDetail[], roles: Roles): Offer[] {
  const offer = (name: string, about: string, step: Record<string, unknown>): Offer => ({
    key: name, name, about, mark: '', edits: (data, path, inside) => [insertion(data, path, inside, step)],
  })
  return [
    { ...offer('For each', 'the same steps for each point of a grid or line, well, row or item', {}), edits: (data, path, inside) => forEach(data, path, inside, devices, roles) },
    offer('At the same time', 'steps that start together', { parallel: [{ steps: [PAUSE] }, { steps: [PAUSE] }] }),
    offer('Watch', 'steps that are stopped, or told of, as soon as something comes true', { steps: [PAUSE], watch: [{ when: '${{ true }}', then: { fail: 'What was watched came true' } }] }),
    offer('Try in order', 'another way if the first one fails', { steps: [PAUSE], fallback: [askWhatNow('It')] }),
    {
      key: 'Always at the end', name: 'Always at the end', about: 'after success, failure and abort', mark: '',
      edits: (data) => atTheEnd(data, devices, roles),
    },
  ]
}

/** A grid to begin with; its first step goes to the point, if the bench has a device that can. */
function forEach(data: unknown, path: Path, inside: boolean, devices: readonly DeviceDetail[], roles: Roles): Edit[] {
  const { list, index } = placeAfter(data, path, inside)
  const names = new Set(loopsAround(data, [...list, index]).map((one) => one.name))
  const ids = new Set<string>()
  gatherIds(data, ids)
  const [name, loop] = [freeId('point', names), fresh('grid')]
  const given = valueAt(data, ['devices'])
  const used = new Set(Object.values(isMap(given) ? given : {}))
  const movers = devices.flatMap((device) => device.actions.filter(movesInPlane).map((action) => ({ device, action })))
  const mover = movers.find(({ device }) => used.has(device.contract)) ?? movers[0]
  const { role, edits } = mover ? roleFor(data, mover.device, roles) : { role: '', edits: [] }
  const step = mover ? { do: `${role}.${mover.action.name}`, with: { x: `\${{ ${name}.x }}`, y: `\${{ ${name}.y }}` } } : PAUSE
  return [...edits, insertion(data, path, inside, { id: freeId('scan', ids), foreach: { [name]: writtenLoop(loop) }, key: keyOf(loop, name), steps: [step] })]
}

function movesInPlane({ params, danger }: ActionForm): boolean {
  const properties = isMap(params['properties']) ? params['properties'] : {}
  const length = (name: string): boolean => isMap(properties[name]) && properties[name]['unit'] === 'mm'
  const needed = Array.isArray(params['required']) ? params['required'].map(String) : []
  return danger === 'motion' && length('x') && length('y') && needed.every((name) => name === 'x' || name === 'y')
}

/** The first safe action of a dangerous device in the protocol that does not run at the end yet. */
function atTheEnd(data: unknown, devices: readonly DeviceDetail[], roles: Roles): Edit[] {
  const list = valueAt(data, ['finally'])
  const there = Array.isArray(list) ? list : []
  const given = valueAt(data, ['devices'])
  const safe = Object.entries(isMap(given) ? given : {})
    .flatMap(([role, contract]) => {
      const bound = roles.find((one) => one.role === role)?.device
      const device = devices.find((one) => one.name === bound) ?? devices.find((one) => one.contract === contract)
      const dangerous = device?.actions.some((action) => action.level === 3) === true
      return dangerous ? device.safe_state.map((action) => `${role}.${action.split('.').at(-1) ?? action}`) : []
    })
    .find((words) => !there.some((step) => isMap(step) && step['do'] === words))
  const step = safe === undefined ? { log: 'The end' } : { do: safe, on_error: 'continue' }
  return lastOfAll(data, step)
}

const PLAIN: [string, string, Record<string, unknown>][] = [
  ['Repeat', 'the same steps a number of times', { repeat: 2, steps: [PAUSE] }],
  ['While', 'the same steps as long as something is true', { while: '${{ true }}', max: 10, steps: [PAUSE] }],
  ['If', 'one of two ways', { if: '${{ true }}', then: [PAUSE] }],
  ['Wait', 'do nothing for a while', { wait: '5 s' }],
  ['Confirm', 'a person confirms before anything else happens', { confirm: 'Ready?' }],
  ['Ask', 'a person chooses', { ask: 'What now?', choices: ['go on', 'stop'] }],
  ['Set', 'a name for a value', { set: { value: 0 } }],
  ['Require', 'the run fails here unless it is true', { require: '${{ true }}' }],
  ['Tell people', 'a message to those whom the lab names', { notify: 'Here' }],
  ['Log', 'a line in the journal', { log: 'Here' }],
  ['Fail', 'with words of your own', { fail: 'It cannot go on' }],
]

export function plainOffers(protocols: readonly string[], name: string): Offer[] {
  const offers = PLAIN.map(([word, about, step]): Offer => ({ key: word, name: word, about, mark: '', edits: (data, path, inside) => [insertion(data, path, inside, step)] }))
  const uses = protocols.filter((one) => one !== name).map((one): Offer => ({
    key: `use ${one}`, name: `Use ${one}`, about: 'the steps of another protocol', mark: '', edits: (data, path, inside) => [insertion(data, path, inside, { use: `./${one}` })],
  }))
  return [...offers, ...uses]
}

export function matching(offers: readonly Offer[], words: string): Offer[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean)
  const found = offers.filter((one) => wanted.every((word) => `${one.name} ${one.key} ${one.about} ${one.mark}`.toLowerCase().includes(word)))
  return found.sort((a, b) => farFrom(words, a) - farFrom(words, b))
}

/** 0 for an offer of this name, 1 for a name that holds it, 2 for one that only its description speaks of. */
export function farFrom(words: string, { name, key }: Offer): number {
  const [wanted, ...names] = [words, name, key].map((one) => one.trim().toLowerCase())
  return names.some((one) => one === wanted) ? 0 : names.some((one) => one.includes(wanted ?? '')) ? 1 : 2
}

