// Draw values over the plane into pixels: one pixel per cell, the highest y on top.
import { colourTable, type ColourMap } from './colours'
import { shareOf, type Scale } from './scale'

/** RGBA bytes, width × height; holes are transparent. */
export interface Pixels {
  width: number
  height: number
  data: Uint8ClampedArray
}

/** One map. `values` come row by row from the lowest y, as the server sends them. */
export function drawMap(
  values: Float32Array, width: number, height: number, scale: Scale, name: ColourMap,
): Pixels {
  const pixels = blank(values, width, height)
  const table = colourTable(name)
  eachCell(width, height, (cell, pixel) => {
    const share = shareOf(scale, values[cell] ?? NaN)
    if (Number.isNaN(share)) return
    const at = Math.round(share * 255) * 3
    pixels.data.set(table.subarray(at, at + 3), pixel * 4)
    pixels.data[pixel * 4 + 3] = 255
  })
  return pixels
}

/** Two colours that are distinct in all kinds of colour vision: orange and blue. */
export const FIRST = [255, 150, 30] as const
export const SECOND = [0, 105, 225] as const

/** Two maps at once: the first as orange, the second as blue, both high gives white. */
export function drawOverlay(
  first: Float32Array, second: Float32Array, width: number, height: number,
  scales: readonly [Scale, Scale],
): Pixels {
  const pixels = blank(first, width, height)
  eachCell(width, height, (cell, pixel) => {
    const a = shareOf(scales[0], first[cell] ?? NaN)
    const b = shareOf(scales[1], second[cell] ?? NaN)
    if (Number.isNaN(a) && Number.isNaN(b)) return
    const [one, two] = [a || 0, b || 0]
    FIRST.forEach((full, part) => {
      pixels.data[pixel * 4 + part] = one * full + two * (SECOND[part] ?? 0)
    })
    pixels.data[pixel * 4 + 3] = 255
  })
  return pixels
}

/** The row of a picture in which a row of cells is drawn: y points up on the bench. */
export function flipped(row: number, height: number): number {
  return height - 1 - row
}

function blank(values: Float32Array, width: number, height: number): Pixels {
  if (values.length !== width * height)
    throw new RangeError(`${values.length} values for a map of ${width} × ${height}`)
  return { width, height, data: new Uint8ClampedArray(width * height * 4) }
}

function eachCell(width: number, height: number, draw: (cell: number, pixel: number) => void): void {
  for (let row = 0; row < height; row++)
    for (let column = 0; column < width; column++)
      draw(row * width + column, flipped(row, height) * width + column)
}
