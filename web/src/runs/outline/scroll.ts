// Which rows of a long list are drawn: the visible ones and some on each side.

export const ROW_PX = 28
const MORE = 8
/** Browsers draw nothing beyond about 16 million pixels. */
const TALLEST_PX = 12_000_000

export interface Shown {
  first: number
  count: number
  /** The position of the first of them, in pixels from the top of the scrolled area. */
  offsetPx: number
  /** The total height. */
  tallPx: number
}

/** Very long lists are compressed: the scroll position is then a share of the rows. */
export function shownRows(size: number, scrollPx: number, heightPx: number): Shown {
  const real = size * ROW_PX
  const tallPx = Math.min(real, TALLEST_PX)
  const share = real > tallPx ? scrollPx / Math.max(1, tallPx - heightPx) : 0
  const topPx = real > tallPx ? share * (real - heightPx) : scrollPx
  const first = Math.max(0, Math.min(size, Math.floor(topPx / ROW_PX)) - MORE)
  const count = Math.min(size - first, Math.ceil(heightPx / ROW_PX) + 2 * MORE)
  return { first, count, offsetPx: scrollPx - (topPx - first * ROW_PX), tallPx }
}

/** Where to scroll to make a row visible; null if it is. */
export function scrollTo(index: number, size: number, scrollPx: number, heightPx: number): number | null {
  const real = size * ROW_PX
  const tallPx = Math.min(real, TALLEST_PX)
  const factor = real > tallPx ? (tallPx - heightPx) / (real - heightPx) : 1
  const topPx = scrollPx / factor
  if (index * ROW_PX < topPx) return index * ROW_PX * factor
  if ((index + 1) * ROW_PX > topPx + heightPx) return ((index + 1) * ROW_PX - heightPx) * factor
  return null
}
