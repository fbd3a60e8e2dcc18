// Which peaks get a label, and where: the strongest first, without overlap.

export interface LabelledPeak {
  nm: number
  height: number
  element: string | null
}

export interface Label {
  text: string
  /** Pixels from the left of the plot. */
  px: number
  nm: number
}

const APART_PX = 34

/** Labels for the visible peaks; `px` turns nm into pixels. Peaks without an element have none. */
export function labelsFor(
  peaks: readonly LabelledPeak[], low: number, high: number, px: (nm: number) => number, most = 24,
): Label[] {
  const inSight = peaks.filter((peak) => peak.element !== null && peak.nm >= low && peak.nm <= high)
  const found: Label[] = []
  for (const peak of [...inSight].sort((a, b) => b.height - a.height)) {
    const at = px(peak.nm)
    if (found.some((other) => Math.abs(other.px - at) < APART_PX)) continue
    found.push({ text: `${peak.element ?? ''} ${peak.nm.toFixed(1)}`, px: at, nm: peak.nm })
    if (found.length === most) break
  }
  return found.sort((a, b) => a.nm - b.nm)
}
