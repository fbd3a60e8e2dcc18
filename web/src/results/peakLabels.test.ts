import { expect, test } from 'vitest'
import { labelsFor } from './peakLabels'

const peak = (nm: number, height: number, element: string | null = 'Li') => ({ nm, height, element })
const px = (nm: number): number => nm

test('the stronger of two close peaks keeps its label', () => {
  const labels = labelsFor([peak(610.4, 5), peak(613, 50, 'Ca'), peak(766.5, 1, 'K')], 190, 950, px)

  expect(labels.map((label) => label.text)).toEqual(['Ca 613.0', 'K 766.5'])
})

test('peaks out of sight and peaks without an element have none', () => {
  expect(labelsFor([peak(300, 9), peak(670.8, 3), peak(700, 99, null)], 600, 800, px)).toHaveLength(1)
})

test('there are no more labels than can be read', () => {
  const many = Array.from({ length: 500 }, (_, i) => peak(200 + i * 40, i))

  expect(labelsFor(many, 0, 1e6, px, 10)).toHaveLength(10)
})
