import { expect, test } from 'vitest'
import { COLOUR_MAPS, colourTable, cssColour } from './colours'

test('viridis has matplotlib’s colours at its ends and middle', () => {
  expect(cssColour('viridis', 0)).toBe('rgb(68, 1, 84)')
  expect(cssColour('viridis', 1)).toBe('rgb(253, 231, 37)')
  const table = colourTable('viridis')
  expect([...table.slice(128 * 3, 128 * 3 + 3)]).toEqual([33, 145, 140])
})

test('every map goes one way in lightness, so that it can be read without colour', () => {
  for (const name of COLOUR_MAPS) {
    const table = colourTable(name)
    const light = Array.from({ length: 9 }, (_, i) => {
      const at = Math.round((i / 8) * 255) * 3
      return 0.2126 * (table[at] ?? 0) + 0.7152 * (table[at + 1] ?? 0) + 0.0722 * (table[at + 2] ?? 0)
    })
    const steps = light.slice(1).map((value, i) => Math.sign(value - (light[i] ?? 0)))

    expect(new Set(steps).size, name).toBe(1)
  }
})

test('shares beyond the ends are drawn as the ends', () => {
  expect(cssColour('cividis', 7)).toBe(cssColour('cividis', 1))
  expect(cssColour('cividis', -7)).toBe(cssColour('cividis', 0))
})
