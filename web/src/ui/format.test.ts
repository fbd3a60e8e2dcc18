import { expect, test } from 'vitest'
import { exact, exactSingle, pointed, sixDigits, typedNumber } from './format'

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

test('a number is read as people write it, and what is none is no other number', () => {
  expect(['12,5', '−3', ' 7.50 ', '+1', '.5', '5.', '1e-3', '−0,5'].map(typedNumber)).toEqual([12.5, -3, 7.5, 1, 0.5, 5, 0.001, -0.5])
  expect(['', '1 000', '1.000,5', '1,2,3', '0x10', '1e999', 'ten', '5 mm', '1e'].map(typedNumber)).toEqual(Array(9).fill(null))
  expect(['1,5 mm/min', '−2 °C', '1,2,3', 'a,5', '1, 2'].map(pointed)).toEqual(['1.5 mm/min', '-2 °C', '1,2,3', 'a,5', '1, 2'])
})

test('no field is of the type number: a browser drops the comma of 12,5 from it, and shows 125', () => {
  const pages = import.meta.glob<string>('../**/*.vue', { query: '?raw', import: 'default', eager: true })

  expect(Object.keys(pages).length).toBeGreaterThan(100)
  expect(Object.entries(pages).filter(([, text]) => text.includes('type="number"')).map(([name]) => name)).toEqual([])
})
