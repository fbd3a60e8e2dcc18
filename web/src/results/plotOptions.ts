// How spectra are drawn by uPlot: axes, lines, zoom by dragging, labels of peaks above.
import type uPlot from 'uplot'
import { labelsFor, type LabelledPeak } from './peakLabels'
import { shortNumber } from './scale'
import type { Theme } from './themes'

/** One curve, over the wavelengths of the plot unless it has its own. */
export interface Curve {
  name: string
  values: Float32Array
  nm?: Float32Array
  colour: string
  dash?: number[]
  width?: number
}

export interface PlotWish {
  width: number
  height: number
  curves: readonly Curve[]
  theme: Theme
  /** Compress the counts axis (asinh), so that small peaks show beside large ones. */
  squeezed: boolean
  /** What the axes are, if not wavelength and counts. */
  names?: readonly [across: string, up: string] | undefined
  peaks: () => readonly LabelledPeak[]
  cursor: (nm: number | null) => void
}

const LABEL_ROOM_PX = 20

export function plotOptions(wish: PlotWish): uPlot.Options {
  const { theme, names: [across, up] = ['wavelength (nm)', 'counts'] } = wish
  const axis = { stroke: theme.muted, grid: { stroke: theme.line, width: 1 }, ticks: { stroke: theme.line, width: 1 }, font: '12px system-ui, sans-serif' }
  return {
    width: wish.width, height: wish.height, padding: [LABEL_ROOM_PX, 12, 0, 0],
    legend: { show: false },
    cursor: { y: false, drag: { x: true, y: false }, points: { show: false } },
    scales: { x: { time: false, range: (plot, low, high) => apart(low, high, plot.data[0]) }, y: { distr: wish.squeezed ? 4 : 1, asinh: 30, range: (_plot, low, high) => headroom(low, high) } },
    axes: [
      { ...axis, label: across, labelSize: 22, labelFont: '12px system-ui, sans-serif', size: 34 },
      { ...axis, label: up, labelSize: 20, labelFont: '12px system-ui, sans-serif', size: 50, values: (_plot, ticks) => ticks.map(shortNumber) },
    ],
    series: [
      {},
      ...wish.curves.map((curve) => ({
        label: curve.name, stroke: curve.colour, width: curve.width ?? 1, points: { show: false },
        ...(curve.dash ? { dash: curve.dash } : {}),
      })),
    ],
    hooks: {
      draw: [(plot) => drawLabels(plot, wish)],
      setCursor: [(plot) => wish.cursor(plot.cursor.idx == null ? null : (plot.data[0][plot.cursor.idx] ?? null))],
    },
  }
}

/** At least ten channels: closer there is nothing to see. */
export function apart(low: number, high: number, nm: ArrayLike<number>): [number, number] {
  const more = (((nm[nm.length - 1] ?? 0) - (nm[0] ?? 0)) / Math.max(100, nm.length / 10) - (high - low)) / 2
  return more > 0 ? [low - more, high + more] : [low, high]
}

/** A margin above the maximum, with the base line visible. */
function headroom(low: number | null, high: number | null): [number, number] {
  if (low === null || high === null || !Number.isFinite(low) || !Number.isFinite(high)) return [0, 1]
  const room = (high - low || Math.abs(high) || 1) * 0.05
  return [low >= 0 && low < 0.2 * high ? 0 : low - room, high + room]
}

function drawLabels(plot: uPlot, { peaks, theme }: PlotWish): void {
  const { ctx, bbox } = plot
  const ratio = devicePixelRatio || 1
  const [low, high] = [plot.scales['x']?.min ?? 0, plot.scales['x']?.max ?? 0]
  const labels = labelsFor(peaks(), low, high, (nm) => plot.valToPos(nm, 'x', true) / ratio)
  ctx.save()
  ctx.fillStyle = theme.text
  ctx.strokeStyle = theme.muted
  ctx.lineWidth = ratio
  ctx.textAlign = 'center'
  ctx.font = `${11 * ratio}px system-ui, sans-serif`
  labels.forEach((label, i) => {
    const x = label.px * ratio
    const y = bbox.top - (i % 2 ? 13 : 3) * ratio
    ctx.fillText(label.text, x, y)
    ctx.beginPath()
    ctx.moveTo(x, bbox.top)
    ctx.lineTo(x, bbox.top + 6 * ratio)
    ctx.stroke()
  })
  ctx.restore()
}

/** The visible range after a key: zoom by + and -, move by the arrows; null if the key does nothing. */
export function keyRange(
  key: string, sight: { min: number; max: number }, whole: { min: number; max: number },
): { min: number; max: number } | null {
  const span = sight.max - sight.min
  const middle = (sight.min + sight.max) / 2
  const fit = (min: number, size: number): { min: number; max: number } => {
    const width = Math.min(size, whole.max - whole.min)
    const from = Math.max(whole.min, Math.min(min, whole.max - width))
    return { min: from, max: from + width }
  }
  switch (key) {
    case '+': case '=': return fit(middle - span / 4, span / 2)
    case '-': return fit(middle - span, span * 2)
    case 'ArrowLeft': return fit(sight.min - span / 10, span)
    case 'ArrowRight': return fit(sight.min + span / 10, span)
    case 'Home': return { ...whole }
    default: return null
  }
}

/** The value nearest to a wavelength; the wavelengths go up. NaN beyond their ends. */
export function valueNear(nm: Float32Array, values: Float32Array, at: number): number {
  let [low, high] = [0, nm.length - 1]
  if (high < 0 || at < (nm[0] ?? 0) || at > (nm[high] ?? 0)) return NaN
  while (high - low > 1) {
    const middle = (low + high) >> 1
    if ((nm[middle] ?? 0) <= at) low = middle
    else high = middle
  }
  return values[at - (nm[low] ?? 0) <= (nm[high] ?? 0) - at ? low : high] ?? NaN
}
