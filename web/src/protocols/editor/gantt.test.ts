import { expect, it } from 'vitest'
import { marksOver } from './gantt'

it.each([
  [4, [0, 1, 2, 3]],
  [14_760, [0, 3_600, 7_200, 10_800]],
  [40_000_000, [0, 8_467_200, 16_934_400, 25_401_600, 33_868_800]],
  [0.3, [0]],
])('marks %d s at round times, with room for their words', (lasts_s, marks) => {
  expect(marksOver(lasts_s)).toEqual(marks)
})
