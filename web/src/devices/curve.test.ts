import { expect, it } from 'vitest'
import { curveOf } from './curve'

it('a spectrum of thousands of values becomes a small curve that keeps its peak', () => {
  const rows = Array.from({ length: 22_800 }, (_, i) => `${(190 + i / 30).toFixed(3)},${i === 14_000 ? 9_999 : 10}`)
  const curve = curveOf(['wavelength,counts', ...rows].join('\n'))

  expect(curve?.points.split(' ').length).toBeLessThan(1_300)
  expect(curve?.words).toBe('22800 values from 190.0 to 950.0, most 9999 at 656.67')
  expect(curve?.points).toContain(',6.0')
})

it('a text that is not a table of numbers is not a curve', () => {
  expect(curveOf('name,value\na,b\n')).toBeNull()
})
