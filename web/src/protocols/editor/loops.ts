// What a loop runs over, as a form: grid, line, plate, values, list or table; anything else is an expression.
import { callOf, innerOf, itemsOf, millimetres, rounded, unquoted, type Argument } from '../text/calls'
import { counted } from '../../ui/format'

export type LoopKind = 'grid' | 'line' | 'plate' | 'values' | 'list' | 'table'

/** `slots` are the parts of the expression as they are written: `10 mm`, `params.width`. */
export interface Loop {
  kind: LoopKind
  slots: Readonly<Record<string, string>>
  /** The items of a list. */
  items?: readonly unknown[]
}

/** Wells -> columns, rows and pitch in mm (ANSI/SLAS 4-2004). */
export const PLATES: Record<string, readonly [number, number, number]> = { 96: [12, 8, 9], 384: [24, 16, 4.5], 1536: [48, 32, 2.25] }
export const ORDERS: Record<string, string> = { rows: 'row by row', snake: 'rows, back and forth', columns: 'column by column' }

/** Null if it is none of the forms. */
export function loopOf(value: unknown): Loop | null {
  if (Array.isArray(value)) return value.every((one) => typeof one !== 'object') ? { kind: 'list', slots: {}, items: value as unknown[] } : null
  const inner = innerOf(value)
  const call = inner === null ? null : callOf(inner)
  switch (call?.name) {
    case 'csv': return tableOf(call.args)
    case 'span': return valuesOf(call.args)
    case 'grid': return gridOf(call.args)
    case 'inside': return insideOf(call.args)
    default: return null
  }
}

function tableOf(args: readonly Argument[]): Loop | null {
  const file = args.length === 1 && args[0]?.key === '' ? unquoted(args[0].text) : null
  return file === null ? null : { kind: 'table', slots: { file } }
}

function valuesOf(args: readonly Argument[]): Loop | null {
  const steps = spanOf(args)
  return steps && { kind: 'values', slots: { from: steps[0], to: steps[1], step: steps[2] } }
}

function spanOf(args: readonly Argument[]): readonly [string, string, string] | null {
  const [from, to, step, fit] = args
  if (!from || !to || !step || args.length > 4 || [from, to, step].some((one) => one.key !== '')) return null
  return fit === undefined || fit.key === 'fit' ? [from.text, to.text, step.text] : null
}

function named(args: readonly Argument[], key: string, place: number): string | undefined {
  return args.find((one) => one.key === key)?.text ?? (args[place]?.key === '' ? args[place].text : undefined)
}

function gridOf(args: readonly Argument[]): Loop | null {
  const [x, y, said] = [named(args, 'x', 0), named(args, 'y', 1), named(args, 'order', 2)]
  const order = said === undefined ? 'rows' : unquoted(said)
  if (x === undefined || y === undefined || order === null || args.length > 3 || ORDERS[order] === undefined) return null
  const [across, along] = [callOf(x), callOf(y)]
  const [xs, ys] = [across?.name === 'span' ? spanOf(across.args) : null, along?.name === 'span' ? spanOf(along.args) : null]
  if (!xs || !ys) return lineOf(x, y)
  return plateOf(xs, ys, order) ?? { kind: 'grid', slots: { x0: xs[0], x1: xs[1], y0: ys[0], y1: ys[1], px: xs[2], py: ys[2], order } }
}

/** A grid of one row or one column. */
function lineOf(x: string, y: string): Loop | null {
  for (const [along, line, other] of [['x', x, y], ['y', y, x]] as const) {
    const call = callOf(line)
    const [at, ...more] = itemsOf(other) ?? []
    if (call?.name !== 'linspace' || call.args.length !== 3 || call.args.some((one) => one.key !== '') || at === undefined || more.length > 0) continue
    const [from = '', to = '', points = ''] = call.args.map((one) => one.text)
    return { kind: 'line', slots: { along, from, to, at, points } }
  }
  return null
}

/** Rows go from A1 towards the front, so that y falls. */
function plateOf(xs: readonly string[], ys: readonly string[], order: string): Loop | null {
  const [x0, x1, px, y0, y1, py] = [...xs, ...ys].map(millimetres)
  if (x0 == null || x1 == null || px == null || y0 == null || y1 == null || py == null) return null
  const found = Object.entries(PLATES).find(([, [columns, rows, pitch]]) =>
    px === pitch && py === -pitch && x1 === rounded(x0 + (columns - 1) * pitch) && y1 === rounded(y0 - (rows - 1) * pitch))
  return found ? { kind: 'plate', slots: { wells: found[0], x0: xs[0] ?? '', y0: ys[0] ?? '', order } } : null
}

/** The points of a grid within an outline. */
function insideOf(args: readonly Argument[]): Loop | null {
  const [points, outline, margin] = [named(args, 'points', 0), named(args, 'outline', 1), named(args, 'margin', 2)]
  const call = points === undefined ? null : callOf(points)
  const grid = call?.name === 'grid' ? gridOf(call.args) : null
  return grid?.kind === 'grid' && outline !== undefined && args.length <= 3 ? { kind: 'grid', slots: { ...grid.slots, outline, margin: margin ?? '' } } : null
}

/** The loop as it is written in a protocol. */
export function writtenLoop({ kind, slots, items }: Loop): unknown {
  const { x0 = '', x1 = '', y0 = '', y1 = '', px = '', py = '', order = 'rows', from = '', to = '' } = slots
  const ordered = order === 'rows' ? '' : `, order='${order}'`
  switch (kind) {
    case 'list': return items ?? []
    case 'table': return `\${{ csv('${slots['file'] ?? ''}') }}`
    case 'values': return `\${{ ${span(from, to, slots['step'] ?? '')} }}`
    case 'line': {
      const [line, one] = [`linspace(${from}, ${to}, ${slots['points'] ?? ''})`, `[${slots['at'] ?? ''}]`]
      return `\${{ grid(x=${slots['along'] === 'y' ? one : line}, y=${slots['along'] === 'y' ? line : one}) }}`
    }
    case 'plate': {
      const [columns, rows, pitch] = PLATES[slots['wells'] ?? ''] ?? [1, 1, 1]
      const end = (start: string, by: number): string => `${String(rounded((millimetres(start) ?? 0) + by))} mm`
      const grid = `x=${span(x0, end(x0, (columns - 1) * pitch), `${String(pitch)} mm`)}, y=${span(y0, end(y0, -(rows - 1) * pitch), `-${String(pitch)} mm`)}`
      return `\${{ grid(${grid}${ordered}) }}`
    }
    case 'grid': {
      const grid = `grid(x=${span(x0, x1, px)}, y=${span(y0, y1, py)}${ordered})`
      const outline = slots['outline'] ?? ''
      const margin = slots['margin'] ? `, ${slots['margin']}` : ''
      return `\${{ ${outline === '' ? grid : `inside(${grid}, ${outline}${margin})`} }}`
    }
  }
}

/** A pitch that does not divide the range ends before it. */
function span(from: string, to: string, step: string): string {
  const fit = stepsIn(from, to, step)?.rest === true ? ", fit='inside'" : ''
  return `span(${from}, ${to}, ${step}${fit})`
}

/** How many steps lead from one to the other, and whether something remains; null if that is not known here. */
function stepsIn(from: string, to: string, step: string): { whole: number; rest: boolean } | null {
  const [first, last, by] = [millimetres(from), millimetres(to), millimetres(step)]
  if (first === null || last === null || by === null || by === 0 || (last - first) / by < -1e-6) return null
  const steps = (last - first) / by
  const near = Math.round(steps)
  return Math.abs(steps - near) > 1e-6 ? { whole: Math.floor(steps), rest: true } : { whole: near, rest: false }
}

/** `6 × 6 = 36 points`, and where they end if not at the edge; empty if it is not known here. */
export function countOf({ kind, slots, items }: Loop): string {
  if (kind === 'list') return counted(items?.length ?? 0, 'item')
  if (kind === 'line') return /^\d+$/.test(slots['points'] ?? '') ? `${slots['points'] ?? ''} points` : ''
  if (kind === 'plate') return `${slots['wells'] ?? ''} wells, ${String(PLATES[slots['wells'] ?? '']?.[2] ?? '')} mm apart; A1 is at the back on the left`
  if (kind === 'values') {
    const steps = stepsIn(slots['from'] ?? '', slots['to'] ?? '', slots['step'] ?? '')
    return steps ? counted(steps.whole + 1, 'value') : ''
  }
  const across = stepsIn(slots['x0'] ?? '', slots['x1'] ?? '', slots['px'] ?? '')
  const along = stepsIn(slots['y0'] ?? '', slots['y1'] ?? '', slots['py'] ?? '')
  if (kind !== 'grid' || !across || !along) return ''
  const ends = (axis: 'x' | 'y', steps: { whole: number; rest: boolean }): string => {
    const last = rounded((millimetres(slots[`${axis}0`]) ?? 0) + steps.whole * (millimetres(slots[`p${axis}`]) ?? 0))
    return steps.rest ? `; the last ${axis} is ${String(last)} mm` : ''
  }
  const points = (across.whole + 1) * (along.whole + 1)
  const inside = slots['outline'] ? ' before the outline' : ''
  return `${String(across.whole + 1)} × ${String(along.whole + 1)} = ${counted(points, 'point')}${inside}${ends('x', across)}${ends('y', along)}`
}

/** The loop that a form begins with; coordinates go on from the one before. */
export function fresh(kind: LoopKind, before: Loop | null = null): Loop {
  const { x0, y0, x1 } = before?.slots ?? {}
  const [x, y] = [x0 ?? before?.slots['from'] ?? '0 mm', y0 ?? before?.slots['at'] ?? '0 mm']
  const beyond = (start: string, mm: number): string => {
    const at = millimetres(start)
    return at === null ? `${start} + ${String(mm)} mm` : `${String(rounded(at + mm))} mm`
  }
  switch (kind) {
    case 'grid': return { kind, slots: { x0: x, x1: beyond(x, 10), y0: y, y1: beyond(y, 10), px: '2 mm', py: '2 mm', order: 'snake' } }
    case 'line': return { kind, slots: { along: 'x', from: x, to: x1 ?? beyond(x, 10), at: y, points: '11' } }
    case 'plate': return { kind, slots: { wells: '96', x0: x === '0 mm' ? '20 mm' : x, y0: y === '0 mm' ? '83 mm' : y, order: 'rows' } }
    case 'values': return { kind, slots: { from: '0 mm', to: '10 mm', step: '1 mm' } }
    case 'list': return { kind, slots: {}, items: ['A', 'B', 'C'] }
    case 'table': return { kind, slots: { file: '' } }
  }
}

/** The permanent name of an iteration; null where its number does. */
export function keyOf({ kind, slots }: Loop, name: string): string | null {
  if (kind === 'grid') return `\${{ ${name}.ix }},\${{ ${name}.iy }}`
  if (kind === 'line') return `\${{ ${name}.index }}`
  const rows = PLATES[slots['wells'] ?? '']?.[1] ?? 99
  return kind === 'plate' && rows <= 16 ? `\${{ '${'ABCDEFGHIJKLMNOP'.slice(0, rows)}'[${name}.iy] }}\${{ ${name}.ix + 1 }}` : null
}

export function hasPoints(loop: Loop | null): boolean {
  return loop !== null && ['grid', 'line', 'plate'].includes(loop.kind)
}
