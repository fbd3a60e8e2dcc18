// The area of a loop as a box with two corners, to drag, draw and teach: of parameters, or written in the loop itself.
import type { Edit } from '../text/edit'
import { isMap, valueAt, type Path } from '../text/path'
import { millimetres, rounded } from '../text/calls'
import type { Box } from './drawing'
import { loopOf, PLATES, writtenLoop, type Loop } from './loops'

export interface Corners {
  at: Box
  /** Every parameter that the area is made of, in the order in which a person thinks of them. */
  params: readonly string[]
  /** The edits that put it there; `what` stays as it is otherwise. A width below zero reaches to the left, a height to the front. */
  to(box: Box, what: 'origin' | 'size' | 'both'): Edit[]
}

/** Null if the loop does not run over points, or they begin somewhere that is not known here. */
export function cornersOf(data: unknown, loop: Path): Corners | null {
  const foreach = valueAt(data, [...loop, 'foreach'])
  const [name, words] = isMap(foreach) ? (Object.entries(foreach)[0] ?? []) : []
  if (typeof words !== 'string' || name === undefined) return null
  return ofParams(data, loop, name, words) ?? ofWords(data, loop, name, words)
}

function ofParams(data: unknown, loop: Path, name: string, words: string): Corners | null {
  if (!/\bgrid\(/.test(words)) return null
  const size = { x: spanEnd(words, 'x'), y: spanEnd(words, 'y') }
  const origin = { x: originIn(valueAt(data, loop), name, 'x'), y: originIn(valueAt(data, loop), name, 'y') }
  const mm = (param: string): number | null => millimetres(valueAt(data, ['params', param, 'default']))
  const [x, y, width, height] = [origin.x, origin.y, size.x, size.y].map((one) => (one === null ? null : mm(one)))
  if (origin.x === null || origin.y === null || size.x === null || size.y === null) return null
  if (x == null || y == null || width == null || height == null) return null
  const [ox, oy, sx, sy] = [origin.x, origin.y, size.x, size.y]
  const steps = [...words.matchAll(/\bparams\.(\w+)/g)].map((match) => match[1] ?? '')
  const params = [...new Set([ox, oy, sx, sy, ...steps])]
  const pitch = params.map((one) => (one === sx || one === sy ? null : mm(one))).at(-1) ?? 0
  const set = (param: string, value: number): Edit => ({ kind: 'set', path: ['params', param, 'default'], value: inMm(value, 3) })
  return {
    params, at: { x, y, width, height },
    to: (wanted, what) => {
      const box = upright(wanted, pitch, pitch, what)
      const origin = [...(what === 'size' && box.x === wanted.x ? [] : [set(ox, box.x)]), ...(what === 'size' && box.y === wanted.y ? [] : [set(oy, box.y)])]
      return [...origin, ...(what === 'origin' ? [] : [set(sx, box.width), set(sy, box.height)])]
    },
  }
}

/** Of a loop whose form holds lengths, and whose points are where the steps go. */
function ofWords(data: unknown, path: Path, name: string, words: string): Corners | null {
  const loop = loopOf(words)
  if (!loop || originIn(valueAt(data, path), name, 'x') !== null || originIn(valueAt(data, path), name, 'y') !== null) return null
  const at = boxOf(loop)
  return at && { params: [], at, to: (box, what) => [{ kind: 'set', path: [...path, 'foreach', name], value: writtenLoop(placed(loop, box, what)) }] }
}

function boxOf({ kind, slots }: Loop): Box | null {
  const mm = (slot: string): number => millimetres(slots[slot]) ?? NaN
  const [columns, rows, pitch] = PLATES[slots['wells'] ?? ''] ?? [1, 1, 0]
  const along = slots['along'] === 'y'
  const boxes: Partial<Record<Loop['kind'], Box>> = {
    grid: { x: mm('x0'), y: mm('y0'), width: mm('x1') - mm('x0'), height: mm('y1') - mm('y0') },
    line: { x: along ? mm('at') : mm('from'), y: along ? mm('from') : mm('at'), width: along ? 0 : mm('to') - mm('from'), height: along ? mm('to') - mm('from') : 0 },
    plate: { x: mm('x0'), y: mm('y0') - (rows - 1) * pitch, width: (columns - 1) * pitch, height: (rows - 1) * pitch },
  }
  const box = boxes[kind]
  return box && Object.values(box).every(Number.isFinite) ? box : null
}

/** The loop over another area. A span that falls goes on falling; a line follows the longer side. */
export function placed(loop: Loop, wanted: Box, what: 'origin' | 'size' | 'both'): Loop {
  const { kind, slots } = loop
  const [px, py] = [millimetres(slots['px']) ?? 0, millimetres(slots['py']) ?? 0]
  const { x, y, width, height } = upright(wanted, px, py, what)
  if (kind === 'grid') {
    const [x0, x1, y0, y1] = [...(px < 0 ? [x + width, x] : [x, x + width]), ...(py < 0 ? [y + height, y] : [y, y + height])].map((mm) => inMm(mm))
    return { ...loop, slots: { ...slots, x0: x0 ?? '', x1: x1 ?? '', y0: y0 ?? '', y1: y1 ?? '' } }
  }
  if (kind === 'plate') return what === 'size' ? loop : { ...loop, slots: { ...slots, x0: inMm(x), y0: inMm(y + height) } }
  const along = what === 'origin' ? (slots['along'] ?? 'x') : width >= height ? 'x' : 'y'
  const [from, length] = along === 'x' ? [x, width] : [y, height]
  const at = what === 'both' ? { x, y } : wanted
  return { ...loop, slots: { ...slots, along, from: inMm(from), to: inMm(from + length), at: inMm(along === 'x' ? at.y : at.x) } }
}

/** The same corners from the lower left one on, its sides in whole steps of the pitch. */
function upright({ x, y, width, height }: Box, px: number, py: number, what: 'origin' | 'size' | 'both'): Box {
  const [across, along] = [whole(Math.abs(width), px, what), whole(Math.abs(height), py, what)]
  return { x: width < 0 ? x - across : x, y: height < 0 ? y - along : y, width: across, height: along }
}

/** As many whole steps of a pitch as come closest; of what is drawn, as many as it holds. */
function whole(mm: number, pitch: number, what: 'origin' | 'size' | 'both'): number {
  const by = Math.abs(pitch)
  if (by === 0 || what === 'origin') return mm
  return Math.max(1, what === 'both' ? Math.floor(mm / by + 1e-6) : Math.round(mm / by)) * by
}

function inMm(mm: number, digits = 6): string {
  return `${String(rounded(Number(mm.toFixed(digits))))} mm`
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

/** Move the start corner there; the size stays. */
export function moveTo({ at, to }: Corners, x: number, y: number): Edit[] {
  return to({ ...at, x, y }, 'origin')
}

/** Move the other corner there, by whole steps of the pitch if there is one. Wherever it lies, the area is between both. */
export function stretchTo({ at, to }: Corners, x: number, y: number): Edit[] {
  return to({ ...at, width: x - at.x, height: y - at.y }, 'size')
}

interface Bounds {
  x0: number | null
  x1: number | null
  y0: number | null
  y1: number | null
}

/** The largest part of a box, on one side of what it may not enter; null if nothing is left. */
export function cutAround(box: Box, { x0, x1, y0, y1 }: Bounds): Box | null {
  const all = { x0: null, x1: null, y0: null, y1: null }
  const sides = [x0 === null ? null : { ...all, x1: x0 }, x1 === null ? null : { ...all, x0: x1 }, y0 === null ? null : { ...all, y1: y0 }, y1 === null ? null : { ...all, y0: y1 }]
  const left = sides.flatMap((side) => (side ? (cutOff(box, side) ?? []) : []))
  return left.sort((a, b) => b.width * b.height - a.width * a.height)[0] ?? null
}

/** What of a box lies within bounds; null if nothing does. */
export function cutOff(box: Box, bounds: Bounds): Box | null {
  const [x0, y0] = [Math.max(box.x, bounds.x0 ?? -Infinity), Math.max(box.y, bounds.y0 ?? -Infinity)]
  const [x1, y1] = [Math.min(box.x + box.width, bounds.x1 ?? Infinity), Math.min(box.y + box.height, bounds.y1 ?? Infinity)]
  const inside = x1 >= x0 && y1 >= y0
  return inside && (x1 > x0 || y1 > y0) ? { x: x0, y: y0, width: Math.max(0, x1 - x0), height: Math.max(0, y1 - y0) } : null
}
