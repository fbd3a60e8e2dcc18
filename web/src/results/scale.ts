// From a value to its share of the colour map, and the marks beside the colour bar.

export const SCALES = ['min–max', 'p2–p98', '0–1'] as const
export type ScaleName = (typeof SCALES)[number]

export interface Range {
  minimum: number | null
  maximum: number | null
  p2: number | null
  p98: number | null
}

/** The values of the lowest and highest colours. `log`: both are above zero. */
export interface Scale {
  low: number
  high: number
  log: boolean
}

/** The scale for a map's values; logarithmic ones begin at the smallest value above zero. */
export function scaleFor(range: Range, name: ScaleName, log: boolean, values?: Float32Array): Scale {
  let [low, high] = ends(range, name)
  if (log) {
    const least = values ? leastAboveZero(values) : low
    low = low > 0 ? low : least > 0 ? least : high / 1000
    if (!(low > 0)) [low, high] = [1e-3, 1]
  }
  if (!(high > low)) high = low === 0 ? 1 : low + Math.abs(low) * 1e-3
  return { low, high, log }
}

function ends(range: Range, name: ScaleName): [number, number] {
  if (name === '0–1') return [0, 1]
  if (name === 'p2–p98') return [range.p2 ?? 0, range.p98 ?? 1]
  return [range.minimum ?? 0, range.maximum ?? 1]
}

function leastAboveZero(values: Float32Array): number {
  let least = Infinity
  for (const value of values) if (value > 0 && value < least) least = value
  return Number.isFinite(least) ? least : 0
}

/** 0 for the lowest, 1 for the highest; values outside are clipped, NaN stays NaN. */
export function shareOf(scale: Scale, value: number): number {
  if (Number.isNaN(value)) return NaN
  const share = scale.log
    ? Math.log(Math.max(value, Number.MIN_VALUE) / scale.low) / Math.log(scale.high / scale.low)
    : (value - scale.low) / (scale.high - scale.low)
  return share < 0 ? 0 : share > 1 ? 1 : share
}

/** Marks beside the colour bar with their shares: a few round numbers. */
export function ticks(scale: Scale, wanted = 4): { value: number; share: number; text: string }[] {
  const values = scale.log ? decades(scale) : rounds(scale, wanted)
  return values.map((value) => ({ value, share: shareOf(scale, value), text: shortNumber(value) }))
}

function rounds({ low, high }: Scale, wanted: number): number[] {
  const rough = (high - low) / wanted
  const power = 10 ** Math.floor(Math.log10(rough))
  const step = ([1, 2, 5, 10].find((m) => m * power >= rough) ?? 10) * power
  const found: number[] = []
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + step * 1e-9; n++) found.push(n * step)
  return found
}

function decades({ low, high }: Scale): number[] {
  const found: number[] = []
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); power++) {
    for (const m of Math.log10(high / low) > 2 ? [1] : [1, 2, 5]) {
      const value = m * 10 ** power
      if (value >= low && value <= high) found.push(value)
    }
  }
  return found.length ? found : [low, high]
}

/** A number as a person writes it: three figures, `12.3k` from ten thousand upwards. */
export function shortNumber(value: number): string {
  if (value === 0 || Object.is(value, -0)) return '0'
  const size = Math.abs(value)
  if (size >= 1e9 || size < 1e-4) return value.toExponential(1)
  if (size >= 1e6) return `${trimmed(value / 1e6)}M`
  if (size >= 1e4) return `${trimmed(value / 1e3)}k`
  return trimmed(value)
}

function trimmed(value: number): string {
  return Number(value.toPrecision(3)).toString()
}
