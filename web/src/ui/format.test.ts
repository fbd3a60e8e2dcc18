import { expect, test } from 'vitest'
import { exact, exactSingle, sixDigits } from './format'

test('a value that is read is exact: every figure, and no more than was measured', () => {
  expect([1071, 104.25, 0.1 + 0.2, -12345.678, 1e-7].map(exact)).toEqual(['1071', '104.25', '0.3', '-12345.678', '1e-7'])
})

test('single precision gains no figures that were never measured', () => {
  const stored = new Float32Array([0.1, 104.25, 1071, 32816.7, -0])

  expect([...stored].map(exactSingle)).toEqual(['0.1', '104.25', '1071', '32816.7', '0'])
})

test('a computed number has six digits, and a whole one all of its own', () => {
  expect([1071, 12_345_678, 104.25, 12.345678912, -0.00012345678].map(sixDigits)).toEqual(['1071', '12345678', '104.25', '12.3457', '-0.000123457'])
})
