import { expect, test } from 'vitest'
import { drawMap } from './mapImage'
import { mapSvg } from './mapSvg'
import { csv } from './saving'

const head = { x: [0, 0.2], y: [0, 0.4], unit: 'mm', column: 'Li <670>' }
const scale = { low: 0, high: 1, log: false }

test('a map as SVG has a rectangle for each measured cell, axes with units, and can be read', () => {
  const pixels = drawMap(new Float32Array([0, 1, NaN, 0.5]), 2, 2, scale, 'viridis')
  const svg = new DOMParser().parseFromString(mapSvg(head, pixels, scale, 'viridis'), 'image/svg+xml')

  expect(svg.querySelectorAll('g rect')).toHaveLength(3)
  expect(svg.documentElement.textContent).toContain('x (mm)')
  expect(svg.documentElement.textContent).toContain('Li <670>')
  expect(svg.querySelector('g rect')?.getAttribute('height')).toBe('400')
  expect([...svg.querySelectorAll('text')].slice(1, 3).map((one) => [one.textContent, one.getAttribute('x')])).toEqual([['0', '156'], ['0.2', '356']])
})

test('CSV has its commas and quotes in quotes, and holes empty', () => {
  expect(csv(['key', 'Li'], [['0,0', 1.5], ['a"b', NaN]])).toBe('key,Li\r\n"0,0",1.5\r\n"a""b",\r\n')
  expect(csv(['a'], [[Math.fround(0.1)], [Math.fround(670.7758)], [16_777_213], [0.1 + 0.2]])).toBe('a\r\n0.1\r\n670.7758\r\n16777213\r\n0.30000000000000004\r\n')
})
