// Random visual edits and their expected results, written independently of the patches.
import type { Edit } from './edit'
import { isMap, valueAt, type Path } from './path'
import { kindOf } from './steps'
import { innerKey } from './unwrapping'
import { WRAPS } from './wrapping'

export type Random = () => number

/** mulberry32: the same numbers for the same seed. */
export function seeded(seed: number): Random {
  let state = seed >>> 0
  return () => {
    state = (state + 0x6d2b79f5) >>> 0
    let mixed = Math.imul(state ^ (state >>> 15), state | 1)
    mixed ^= mixed + Math.imul(mixed ^ (mixed >>> 7), mixed | 61)
    return ((mixed ^ (mixed >>> 14)) >>> 0) / 4294967296
  }
}

export function pick<T>(random: Random, all: readonly T[]): T {
  const one = all[Math.floor(random() * all.length)]
  if (one === undefined) throw new Error('nothing to pick from')
  return one
}

interface Found {
  steps: Path[]
  lists: Path[]
  values: Path[]
}

function survey(data: unknown, path: Path, into: Found): Found {
  if (Array.isArray(data)) {
    if (data.length === 0 || data.some((item) => kindOf(item) !== null)) into.lists.push(path)
    data.forEach((item, i) => survey(item, [...path, i], into))
  } else if (isMap(data)) {
    if (kindOf(data) !== null && typeof path.at(-1) === 'number') into.steps.push(path)
    for (const [key, value] of Object.entries(data)) survey(value, [...path, key], into)
  }
  if (path.length > 0) into.values.push(path)
  return into
}

const VALUES: readonly unknown[] = [
  0, 7, -2.5, true, false, null, '', 'x', 'two words', '12 mm', '0.2 mm', '30 s', 'yes', 'null', '1e5', '0x1F', '1:30', '2026-11-21', ' lead',
  'trail ', 'a: b', 'a # b', '- dash', '#no', "it's", 'say "x"', 'line\nbreak', 'ünï → ✓', '${{ params.x0 + point.x }}', "${{ csv('a.csv') }}",
  '*star', '&and', '!bang', '%', '@at', '`tick', '[a]', '{a: 1}', ',', 'a,b', 'tab\there', '\\', '?', ': ', 'end:', '~',
]
const COLLECTIONS: readonly unknown[] = [
  { attempts: 3, wait: '2 s' }, { attempts: 5, on: ['Timeout'] }, ['Li', 'K'], {}, [], { x: '${{ point.x }}', y: 0 }, [[1, 2], { a: null }],
]
const STEPS: readonly Record<string, unknown>[] = [
  { do: 'gantry.home' }, { do: 'gantry.move_to', with: { x: '10 mm', y: '${{ params.y }}' } }, { log: 'Here: # not a comment' }, { wait: '5 s' },
  { id: 'again', repeat: 2, steps: [{ do: 'libs.measure', retry: { attempts: 3, wait: '2 s' } }, { confirm: 'Fine?' }] },
  { parallel: [{ do: 'a.b' }, { do: 'c.d', with: { long: 'x'.repeat(90) } }] },
]
const KEYS = ['name', 'retry', 'timeout', 'on_error', 'note', 'with', 'when', 'id', 'x y', '1', 'null', 'elements']

export function randomEdit(random: Random, data: unknown): Edit {
  const found = survey(data, [], { steps: [], lists: [], values: [] })
  const value = random() < 0.75 ? pick(random, VALUES) : pick(random, COLLECTIONS)
  const kinds = ['set', 'set', 'add', 'add', 'drop', 'rename', 'insert', 'insert', 'remove', 'move', 'move', 'move', 'near', 'near', 'duplicate', 'wrap', 'wrap', 'unwrap', 'unwrap', 'note'] as const
  const kind = found.steps.length === 0 ? 'insert' : pick(random, kinds)
  switch (kind) {
    case 'set': return { kind, path: pick(random, found.values), value }
    case 'add': return { kind: 'set', path: [...pick(random, found.steps), pick(random, KEYS)], value }
    case 'drop': return { kind, path: pick(random, found.values) }
    case 'rename': return { kind, path: pick(random, found.values), name: pick(random, KEYS) }
    case 'insert': {
      const path = found.lists.length > 0 && random() < 0.9 ? pick(random, found.lists) : ['steps']
      const list = valueAt(data, path)
      const many = random() < 0.3 ? [pick(random, STEPS), pick(random, STEPS)] : [pick(random, STEPS)]
      return { kind, path, index: Math.floor(random() * ((Array.isArray(list) ? list.length : 0) + 1)), values: many }
    }
    case 'move': {
      const to: Path = random() < 0.1 ? ['finally'] : pick(random, found.lists)
      const list = valueAt(data, to)
      return { kind, path: pick(random, found.steps), to, index: Math.floor(random() * ((Array.isArray(list) ? list.length : 0) + 1)) }
    }
    case 'near': {
      const path = pick(random, found.steps)
      const list = valueAt(data, path.slice(0, -1)) as unknown[]
      return { kind: 'move', path, to: path.slice(0, -1), index: Math.floor(random() * (list.length + 1)) }
    }
    case 'unwrap': {
      const holders = found.steps.filter((path) => innerKey(kindOf(valueAt(data, path))) !== null)
      return { kind, path: pick(random, holders.length > 0 ? holders : found.steps) }
    }
    case 'note': return { kind, path: pick(random, found.steps), note: pick(random, ['', 'one line', 'two\nlines', '# odd']) }
    case 'wrap': return { kind, path: pick(random, found.steps), wrap: pick(random, WRAPS), more: Math.floor(random() * 3) }
    default: return { kind, path: pick(random, found.steps) }
  }
}
