// The grid of a loop as two corners: the parameters for its start and size.
import type { Edit } from '../text/edit'
import { isMap, valueAt, type Path } from '../text/path'

export interface Corners {
  /** Parameters of its start corner and its size, each in mm. */
  origin: { x: string; y: string }
  size: { x: string; y: string }
  /** Every parameter that the grid is made of, in the order in which a person thinks of them. */
  params: string[]
  at: { x: number; y: number; width: number; height: number }
}

const IN_MM: Record<string, number> = { mm: 1, '': 1, cm: 10, m: 1000, um: 0.001, µm: 0.001 }

/** Null if the loop does not run over a grid, or its corners are not parameters. */
export function cornersOf(data: unknown, loop: Path): Corners | null {
  const foreach = valueAt(data, [...loop, 'foreach'])
  const [name, words] = isMap(foreach) ? (Object.entries(foreach)[0] ?? []) : []
  if (typeof words !== 'string' || name === undefined || !/\bgrid\(/.test(words)) return null
  const size = { x: spanEnd(words, 'x'), y: spanEnd(words, 'y') }
  const origin = { x: originIn(valueAt(data, loop), name, 'x'), y: originIn(valueAt(data, loop), name, 'y') }
  const [x, y, width, height] = [origin.x, origin.y, size.x, size.y].map((one) => (one === null ? null : millimetres(data, one)))
  if (origin.x === null || origin.y === null || size.x === null || size.y === null) return null
  if (x == null || y == null || width == null || height == null) return null
  const steps = [...words.matchAll(/\bparams\.(\w+)/g)].map((match) => match[1] ?? '')
  const params = [...new Set([origin.x, origin.y, size.x, size.y, ...steps])]
  return { origin: { x: origin.x, y: origin.y }, size: { x: size.x, y: size.y }, params, at: { x, y, width, height } }
}

/** `params.width` of `x=span(0, params.width, params.pitch)`. */
function spanEnd(words: string, axis: 'x' | 'y'): string | null {
  return new RegExp(`\\b${axis}\\s*=\\s*span\\(\\s*0[^,]*,\\s*params\\.(\\w+)\\s*[,)]`).exec(words)?.[1] ?? null
}

/** `x0` of `params.x0 + point.x`, wherever it occurs in the loop's steps. */
function originIn(data: unknown, name: string, axis: 'x' | 'y'): string | null {
  if (typeof data === 'string') {
    const match = new RegExp(`\\bparams\\.(\\w+)\\s*\\+\\s*${name}\\.${axis}\\b|\\b${name}\\.${axis}\\s*\\+\\s*params\\.(\\w+)`).exec(data)
    return match?.[1] ?? match?.[2] ?? null
  }
  const inner = Array.isArray(data) ? (data as unknown[]) : isMap(data) ? Object.values(data) : []
  for (const one of inner) {
    const found = originIn(one, name, axis)
    if (found !== null) return found
  }
  return null
}

function millimetres(data: unknown, param: string): number | null {
  const given = valueAt(data, ['params', param, 'default'])
  if (typeof given === 'number') return given
  const match = typeof given === 'string' ? /^\s*([-+]?[\d.]+)\s*(\S*)\s*$/.exec(given) : null
  const factor = IN_MM[match?.[2] ?? '?']
  return match && factor !== undefined ? Number(match[1]) * factor : null
}

function set(param: string, mm: number): Edit {
  return { kind: 'set', path: ['params', param, 'default'], value: `${String(Math.round(mm * 1000) / 1000)} mm` }
}

/** Move the start corner there; the size stays. */
export function moveTo({ origin }: Corners, x: number, y: number): Edit[] {
  return [set(origin.x, x), set(origin.y, y)]
}

/** Move the other corner there, by whole steps of the pitch if there is one. */
export function stretchTo(data: unknown, { size, params, at }: Corners, x: number, y: number): Edit[] {
  const pitch = params.map((one) => (Object.values(size).includes(one) ? null : millimetres(data, one))).at(-1) ?? 0
  const whole = (mm: number): number => (pitch > 0 ? Math.max(1, Math.round(mm / pitch)) * pitch : mm)
  return [set(size.x, whole(x - at.x)), set(size.y, whole(y - at.y))]
}
