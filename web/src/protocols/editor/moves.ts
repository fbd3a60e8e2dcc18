// Where Alt with an arrow takes a step: past its neighbour, out of its structure, into the one above.
import type { Edit } from '../text/edit'
import { isMap, valueAt, type Path } from '../text/path'
import { kindOf } from '../text/steps'
import { innerKey } from '../text/unwrapping'

export type Way = 'up' | 'down' | 'out' | 'in'

/** Null if there is nowhere to go that way. */
export function moveOf(data: unknown, path: Path, way: Way): Edit | null {
  const at = path.at(-1)
  const list = path.slice(0, -1)
  const all = valueAt(data, list)
  if (typeof at !== 'number' || !Array.isArray(all)) return null
  const move = (to: Path, index: number): Edit => ({ kind: 'move', path, to, index })
  if (way === 'up' && at > 0) return move(list, at - 1)
  if (way === 'down' && at < all.length - 1) return move(list, at + 2)
  if (way === 'in') {
    const above = valueAt(data, [...list, at - 1])
    const key = innerKey(kindOf(above))
    const inner = isMap(above) && key !== null ? above[key] : undefined
    return key !== null && Array.isArray(inner) ? move([...list, at - 1, key], inner.length) : null
  }
  const owner = ownerOf(data, list)
  if (!owner) return null
  const ownerAt = Number(owner.at(-1))
  return move(owner.slice(0, -1), way === 'up' ? ownerAt : ownerAt + 1)
}

/** The step that holds a list. */
function ownerOf(data: unknown, list: Path): Path | null {
  for (let length = list.length - 1; length > 1; length--) {
    const path = list.slice(0, length)
    if (typeof path.at(-1) === 'number' && Array.isArray(valueAt(data, path.slice(0, -1)))) return path
  }
  return null
}

/** Where a new step goes: into the list of the row, or after the row. */
export function placeAfter(data: unknown, path: Path, inside: boolean): { list: Path; index: number } {
  const value = valueAt(data, path)
  // Other ways are tried before a person is asked.
  if (path.at(-1) === 'fallback') return { list: path, index: Array.isArray(value) ? value.length - (kindOf(value.at(-1)) === 'ask' ? 1 : 0) : 0 }
  if (path.at(-1) === 'else' && value === undefined) return { list: path, index: 0 }
  if (Array.isArray(value) && path.length > 0) return { list: path, index: value.length }
  const key = inside ? innerKey(kindOf(value)) : null
  const inner = key !== null && isMap(value) ? value[key] : undefined
  if (key !== null && Array.isArray(inner)) return { list: [...path, key], index: inner.length }
  const at = path.at(-1)
  if (typeof at === 'number') return { list: path.slice(0, -1), index: at + 1 }
  const steps = valueAt(data, ['steps'])
  return { list: ['steps'], index: Array.isArray(steps) ? steps.length : 0 }
}
