// Colours of classes: eight that are distinct in all kinds of colour vision (Okabe and Ito, 2008).
import type { Pixels } from './mapImage'
import { flipped } from './mapImage'

export const CLASS_COLOURS = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#f0e442', '#999999'] as const

/** Classes count from 1; after eight the colours repeat. */
export function classColour(number: number): string {
  return CLASS_COLOURS[(Math.max(1, Math.round(number)) - 1) % CLASS_COLOURS.length] ?? '#999999'
}

/** A map whose values are class numbers. */
export function drawClasses(values: Float32Array, width: number, height: number): Pixels {
  const data = new Uint8ClampedArray(width * height * 4)
  for (let cell = 0; cell < width * height; cell++) {
    const value = values[cell] ?? NaN
    if (Number.isNaN(value)) continue
    const rgb = parseInt(classColour(value).slice(1), 16)
    const pixel = flipped(Math.floor(cell / width), height) * width + (cell % width)
    data.set([rgb >> 16, (rgb >> 8) & 255, rgb & 255, 255], pixel * 4)
  }
  return { width, height, data }
}

/** The class numbers that occur. */
export function classesIn(values: Float32Array): { number: number; count: number }[] {
  const counts = new Map<number, number>()
  for (const value of values) if (!Number.isNaN(value)) counts.set(value, (counts.get(value) ?? 0) + 1)
  return [...counts].map(([number, count]) => ({ number, count })).sort((a, b) => a.number - b.number)
}
