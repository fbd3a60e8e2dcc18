// Draw a path over the bench: millimetres to pixels, the limits, the points, the selected point.
import type { Received } from '../../api/types'
import { type Colour, drawArea, drawKeptOut, drawRuler, MARGIN } from './ground'
import type { Photograph } from './photograph'

type Track = Received<'Track'>

/** Between millimetres of the bench and pixels of the picture; y goes up. */
export interface Frame {
  width: number
  height: number
  scale: number
  px(x: number): number
  py(y: number): number
  xOf(px: number): number
  yOf(py: number): number
}

const LEAST_MM = 1

/** Around the points and the grid that they are of, the whole area, or a part of the bench. */
export function frameOf(track: Track, width: number, height: number, shown: 'points' | 'bench' | Box, grid: Box | null = null): Frame {
  const { area } = track
  let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity]
  track.x_mm.forEach((x, i) => {
    const y = track.y_mm[i] ?? 0
    ;[x0, x1, y0, y1] = [Math.min(x0, x), Math.max(x1, x), Math.min(y0, y), Math.max(y1, y)]
  })
  if (grid) [x0, x1, y0, y1] = [Math.min(x0, grid.x), Math.max(x1, grid.x + grid.width), Math.min(y0, grid.y), Math.max(y1, grid.y + grid.height)]
  if (typeof shown === 'object') [x0, x1, y0, y1] = [shown.x, shown.x + shown.width, shown.y, shown.y + shown.height]
  else if (shown === 'bench' || !Number.isFinite(x0)) {
    ;[x0, x1] = [Math.min(x0, area.x0 ?? x0), Math.max(x1, area.x1 ?? x1)]
    ;[y0, y1] = [Math.min(y0, area.y0 ?? y0), Math.max(y1, area.y1 ?? y1)]
  }
  if (!Number.isFinite(x0)) [x0, x1, y0, y1] = [0, 100, 0, 100]
  const scale = Math.min((width - 2 * MARGIN) / Math.max(x1 - x0, LEAST_MM), (height - 2 * MARGIN) / Math.max(y1 - y0, LEAST_MM))
  const left = (width - (x1 - x0) * scale) / 2
  const bottom = height - (height - (y1 - y0) * scale) / 2
  return {
    width, height, scale,
    px: (x) => left + (x - x0) * scale, py: (y) => bottom - (y - y0) * scale,
    xOf: (px) => (px - left) / scale + x0, yOf: (py) => (bottom - py) / scale + y0,
  }
}

/** What is shown once it is nearer or farther by a factor; the place stays where it is. */
export function zoomed({ width, height, xOf, yOf }: Frame, at: Spot, factor: number): Box {
  const [left, right, front, back] = [xOf(MARGIN), xOf(width - MARGIN), yOf(height - MARGIN), yOf(MARGIN)]
  const by = Math.max(factor, LEAST_MM / Math.min(right - left, back - front))
  return { x: at.x + (left - at.x) * by, y: at.y + (front - at.y) * by, width: (right - left) * by, height: (back - front) * by }
}

/** A place on the bench in mm. */
export interface Spot {
  x: number
  y: number
}

/** A rectangle of the bench in mm. */
export interface Box extends Spot {
  width: number
  height: number
}

export interface Look {
  corners: Box | null
  /** The box is where it may not be. */
  wrong?: boolean
  point: number
  lit: number
  ratio: number
  photograph?: Photograph | null
}

export function draw(canvas: HTMLCanvasElement, track: Track, frame: Frame, { point, lit, ratio, corners, wrong = false, photograph = null }: Look): void {
  const brush = canvas.getContext('2d')
  if (!brush) return
  const style = getComputedStyle(canvas)
  const colour = (name: string): string => style.getPropertyValue(`--${name}`).trim()
  brush.setTransform(ratio, 0, 0, ratio, 0, 0)
  brush.clearRect(0, 0, frame.width, frame.height)
  brush.fillStyle = colour('panel')
  brush.fillRect(0, 0, frame.width, frame.height)
  drawArea(brush, track, frame, colour, photograph)
  drawKeptOut(brush, track.keep_out, frame, colour)
  drawRuler(brush, frame, colour('muted'))
  drawPath(brush, track, frame, colour(photograph ? 'accent' : 'line-strong'))
  drawPoints(brush, track, frame, lit, colour, photograph !== null)
  if (corners) drawCorners(brush, corners, frame, wrong ? (name) => colour(name === 'accent' ? 'fail' : name) : colour)
  drawCross(brush, track, frame, point, colour('text'))
}

function drawPath(brush: CanvasRenderingContext2D, track: Track, frame: Frame, colour: string): void {
  brush.strokeStyle = colour
  brush.beginPath()
  track.x_mm.forEach((x, i) => {
    const [px, py] = [frame.px(x), frame.py(track.y_mm[i] ?? 0)]
    if (track.joined[i]) brush.lineTo(px, py)
    else brush.moveTo(px, py)
  })
  brush.stroke()
}

function drawPoints(brush: CanvasRenderingContext2D, track: Track, frame: Frame, lit: number, colour: Colour, rimmed: boolean): void {
  const outside = new Set(track.outside)
  const within = (at: number, low: number | null, high: number | null): boolean => at > (low ?? -Infinity) && at < (high ?? Infinity)
  track.x_mm.forEach((x, i) => {
    if (track.keep_out.some((box) => within(x, box.x0, box.x1) && within(track.y_mm[i] ?? 0, box.y0, box.y1))) outside.add(i)
  })
  const size = Math.max(1.5, Math.min(7, frame.scale * spacing(track) * 0.45))
  const [plain, bright, wrong] = [colour('accent'), colour('paused'), colour('fail')]
  track.x_mm.forEach((x, i) => {
    brush.fillStyle = outside.has(i) ? wrong : track.track[i] === lit ? bright : plain
    const [px, py] = [frame.px(x), frame.py(track.y_mm[i] ?? 0)]
    if (outside.has(i)) {
      brush.strokeStyle = wrong
      brush.strokeRect(px - 4, py - 4, 8, 8)
    }
    if (rimmed) {
      const inside = brush.fillStyle
      brush.fillStyle = colour('bg')
      brush.fillRect(px - size / 2 - 1, py - size / 2 - 1, size + 2, size + 2)
      brush.fillStyle = inside
    }
    brush.fillRect(px - size / 2, py - size / 2, size, size)
  })
}

/** The grid as a box, with two corners to drag. */
function drawCorners(brush: CanvasRenderingContext2D, { x, y, width, height }: Box, frame: Frame, colour: Colour): void {
  brush.strokeStyle = colour('accent')
  brush.strokeRect(frame.px(x), frame.py(y + height), width * frame.scale, height * frame.scale)
  brush.font = 'bold 11px system-ui, sans-serif'
  brush.textAlign = 'center'
  for (const [word, cx, cy] of [['A', x, y], ['B', x + width, y + height]] as const) {
    brush.fillStyle = colour('accent')
    brush.beginPath()
    brush.arc(frame.px(cx), frame.py(cy), 9, 0, 2 * Math.PI)
    brush.fill()
    brush.fillStyle = colour('on-accent')
    brush.fillText(word, frame.px(cx), frame.py(cy) + 4)
  }
}

function drawCross(brush: CanvasRenderingContext2D, track: Track, frame: Frame, point: number, colour: string): void {
  const [x, y] = [track.x_mm[point], track.y_mm[point]]
  if (x === undefined || y === undefined) return
  const [px, py] = [frame.px(x), frame.py(y)]
  brush.strokeStyle = colour
  brush.lineWidth = 2
  brush.beginPath()
  brush.arc(px, py, 7, 0, 2 * Math.PI)
  brush.moveTo(px - 13, py)
  brush.lineTo(px - 4, py)
  brush.moveTo(px + 4, py)
  brush.lineTo(px + 13, py)
  brush.moveTo(px, py - 13)
  brush.lineTo(px, py - 4)
  brush.moveTo(px, py + 4)
  brush.lineTo(px, py + 13)
  brush.stroke()
  brush.lineWidth = 1
}

/** The typical distance from one point to the next, in mm. */
function spacing(track: Track): number {
  const ways: number[] = []
  for (let i = 1; i < Math.min(track.x_mm.length, 200); i++) {
    const way = Math.hypot((track.x_mm[i] ?? 0) - (track.x_mm[i - 1] ?? 0), (track.y_mm[i] ?? 0) - (track.y_mm[i - 1] ?? 0))
    if (way > 0) ways.push(way)
  }
  return ways.sort((a, b) => a - b)[ways.length >> 1] ?? 10
}
