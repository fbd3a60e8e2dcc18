// Marks on an axis of time: round widths of time, few enough that their words have room.
const WIDTHS_S = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1_800, 3_600, 7_200, 14_400, 21_600, 43_200, 86_400, 172_800, 604_800]
const MOST = 5

/** Seconds from 0 on, none so near the end that it has no room. */
export function marksOver(lasts_s: number): number[] {
  const width = WIDTHS_S.find((one) => lasts_s / one <= MOST) ?? 604_800 * Math.ceil(lasts_s / 604_800 / MOST)
  const marks = []
  for (let at = 0; at <= 0.92 * lasts_s; at += width) marks.push(at)
  return marks
}
