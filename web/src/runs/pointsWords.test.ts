import { expect, test } from 'vitest'
import { pointsWords } from './pointsWords'

test('plan, measured, failed and left are told in one way', () => {
  expect(pointsWords({ total: 35, measured: 7, failed: 2, left: 26 })).toEqual(['7 of 35 measured', '2 failed', '26 left'])
  expect(pointsWords({ total: 1071, measured: 1071, failed: 0, left: 0 })).toEqual(['1,071 of 1,071 measured'])
  expect(pointsWords({ total: null, measured: 3, failed: 1, left: null })).toEqual(['3 measured', '1 failed'])
  expect(pointsWords({ total: null, measured: 0, failed: 0, left: null })).toEqual([])
})
