import { expect, test } from 'vitest'
import { errorColumn, exact, exactSingle, figures, pointed, typedNumber } from './format'

test('a value that is read is exact: every figure, and no more than was measured', () => {
  expect([1071, 104.25, 0.1 + 0.2, -12345.678, 1e-7].map(exact)).toEqual(['1071', '104.25', '0.3', '-12345.678', '1e-7'])
})

test('single precision gains no figures that were never measured', () => {
  const stored = new Float32Array([0.1, 104.25, 1071, 32816.7, -0])

  expect([...stored].map(exactSingle)).toEqual(['0.1', '104.25', '1071', '32816.7', '0'])
})

test('a computed number has six digits, and a whole one all of its own', () => {
  expect([1071, 12_345_678, 104.25, 12.345678912, -0.00012345678].map((one) => figures(one))).toEqual(['1071', '12345678', '104.25', '12.3457', '-0.000123457'])
  expect([0.1 + 0.2, 1234.5678901234, 12_345_678.9, 1.5e-9, NaN].map((one) => figures(one))).toEqual(['0.3', '1234.57', '12345679', '1.5e-9', 'NaN'])
})

test('the error of a number says how many of its digits are read', () => {
  const told: [number, number, string][] = [[12.345678, 0.0123, '12.346'], [0.5, 0.013, '0.500'], [11_905.6, 230, '11910'], [-0.0001, 0.02, '0.000'], [0.0123, 0.0123, '0.012'], [1.5, 0, '1.5'], [1.234567891, 1e-12, '1.23457'], [1071, NaN, '1071']]

  expect(told.map(([value, error]) => figures(value, error))).toEqual(told.map(([, , text]) => text))
  const columns = ['temperature_k', 'temperature_error_k', 'area', 'area_err', 'log10_ne', 'log10_ne_err', 'wt_percent', 'wt_percent_err', 'x_mm']
  expect(columns.map((one) => errorColumn(one, columns))).toEqual(['temperature_error_k', undefined, 'area_err', undefined, 'log10_ne_err', undefined, 'wt_percent_err', undefined, undefined])
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
