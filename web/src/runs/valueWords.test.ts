import { expect, test } from 'vitest'
import { allOf, valueWords } from './valueWords'

test('values are written as people write them', () => {
  const values = [null, 1071, 104.25, 0.0058, 'core', true, { $quantity: [20, 'mm'] }, { $quantity: [600, 'mm / min'] }, { $moment: '2026-11-24T07:00:00+01:00' }, [1, 2], { Li: 12.5, K: null }]

  expect(values.map((one) => valueWords(one))).toEqual(['–', '1071', '104.25', '0.0058', 'core', 'true', '20 mm', '600 mm/min', '2026-11-24T07:00:00+01:00', '1, 2', 'Li 12.5, K –'])
  expect(valueWords(Array(1000).fill(1))).toBe('1000 values')
  expect([valueWords, allOf].map((words) => words({ $quantity: [11905.607575232, 'K'] }))).toEqual(['11905.6 K', '11905.607575232 K'])
})
