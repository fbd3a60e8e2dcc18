// Paint a run's map: the status of every point, or a value of it; single cells when they change.
import { cssColour, type ColourMap } from '../../results/colours'
import { shareOf, type Scale } from '../../results/scale'
import type { Theme } from '../../results/themes'
import type { PointTable } from '../points'
import { STATUS_LOOKS, type Status } from '../status'
import { rectOf, type Frame } from './frame'
import type { Layout } from './layout'

export interface Values {
  scale: Scale
  colours: ColourMap
  /** The value of a point, NaN for none. */
  of: (index: number) => number
}

/** Everything that a cell's colour depends on. */
export interface Painting {
  ctx: CanvasRenderingContext2D
  frame: Frame
  layout: Layout
  table: PointTable
  theme: Theme
  values: Values | null
}

/** Cells at least this wide get the icon of their status. */
const ICON_PX = 12

export function paintAll(painting: Painting): void {
  const { ctx, layout } = painting
  ctx.clearRect(0, 0, ctx.canvas.width, ctx.canvas.height)
  for (let cell = 0; cell < layout.point.length; cell++) paintCell(painting, cell)
}

/** Paint one cell over what was there. */
export function paintCell({ ctx, frame, layout, table, theme, values }: Painting, cell: number): void {
  const index = layout.point[cell] ?? -1
  const [x, y, w, h] = rectOf(frame, cell)
  const gap = w >= 6 ? 1 : 0
  ctx.clearRect(x, y, w, h)
  if (index < 0) return
  const status = table.status(index)
  ctx.fillStyle = values ? valueColour(values, index, theme) : statusColour(status, theme)
  ctx.fillRect(x, y, w - gap, h - gap)
  if (values && status !== 'failed' && status !== 'running') return
  if (w < ICON_PX || h < ICON_PX) {
    if (status === 'failed' && w >= 4) cross(ctx, x, y, w - gap, h - gap, theme.bg)
    return
  }
  ctx.fillStyle = status === 'waiting' || values ? theme.muted : theme.bg
  ctx.font = `${Math.min(15, Math.floor(w * 0.62))}px system-ui, sans-serif`
  ctx.textAlign = 'center'
  ctx.textBaseline = 'middle'
  ctx.fillText(STATUS_LOOKS[status].icon, x + (w - gap) / 2, y + (h - gap) / 2 + 0.5)
}

function statusColour(status: Status, theme: Theme): string {
  const tone = STATUS_LOOKS[status].tone
  return status === 'waiting' ? theme.line : tone === 'muted' ? theme.muted : theme[tone]
}

function valueColour({ scale, colours, of }: Values, index: number, theme: Theme): string {
  const share = shareOf(scale, of(index))
  return Number.isNaN(share) ? theme.line : cssColour(colours, share)
}

/** A failed point also differs by shape where a cell is too small for an icon. */
function cross(ctx: CanvasRenderingContext2D, x: number, y: number, w: number, h: number, colour: string): void {
  ctx.strokeStyle = colour
  ctx.lineWidth = 1
  ctx.beginPath()
  ctx.moveTo(x + 1, y + 1)
  ctx.lineTo(x + w - 1, y + h - 1)
  ctx.moveTo(x + w - 1, y + 1)
  ctx.lineTo(x + 1, y + h - 1)
  ctx.stroke()
}
