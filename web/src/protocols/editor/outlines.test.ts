import { expect, it } from 'vitest'
import { boxAround, outlineTable, samplesOf, throughThree } from './outlines'

const CORE = { outline: [{ x: 10.004, y: 20 }, { x: 30.27, y: 20 }, { x: 20, y: 60.11 }], x: 20, y: 33 }

it('an outline becomes a table, and the box around it', () => {
  const [core, ...more] = samplesOf({ samples: [CORE, { outline: [{ x: 1, y: 2 }] }, { outline: [{ x: 1 }, { x: 2 }, { x: 3 }] }, 7] })

  expect(more).toEqual([])
  expect(core).toEqual(CORE)
  expect(outlineTable(CORE.outline)).toBe('x (mm),y (mm)\n10,20\n30.27,20\n20,60.11\n')
  expect(boxAround(CORE.outline)).toEqual({ x: 10, y: 20, width: 20.3, height: 40.2 })
  expect(boxAround([{ x: 1.99999999, y: 2.00000001 }, { x: 22.0000001, y: 31.999999 }])).toEqual({ x: 2, y: 2, width: 20, height: 30 })
  expect(samplesOf(null)).toEqual([])
})

it('three corners are an outline that lies turned, unless they are in one line', () => {
  const [a, b, c] = [{ x: 10, y: 0 }, { x: 30, y: 20 }, { x: 20, y: 30 }]

  expect(throughThree([a, b, c])).toEqual([a, b, c, { x: 0, y: 10 }])
  expect(throughThree([a, b, { x: 50, y: 40.01 }])).toBe(null)
  expect(throughThree([a, a, c])).toBe(null)
})
