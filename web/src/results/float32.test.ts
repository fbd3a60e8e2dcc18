import { expect, test } from 'vitest'
import { decodeFit, decodeFloat32 } from './float32'

function bytes(...values: number[]): ArrayBuffer {
  const view = new DataView(new ArrayBuffer(values.length * 4))
  values.forEach((value, i) => view.setFloat32(i * 4, value, true))
  return view.buffer
}

test('values arrive as sent, holes as NaN', () => {
  expect([...decodeFloat32(bytes(1.5, NaN, -2), 3)]).toEqual([1.5, NaN, -2])
})

test('an answer of another length is refused', () => {
  expect(() => decodeFloat32(bytes(1, 2), 3)).toThrow('2 values received, 3 expected')
  expect(() => decodeFloat32(new ArrayBuffer(5))).toThrow('5 bytes')
})

test('three curves come one after the other', () => {
  const { background, fit, residual } = decodeFit(bytes(1, 2, 3, 4, 5, 6))

  expect([[...background], [...fit], [...residual]]).toEqual([[1, 2], [3, 4], [5, 6]])
  expect(() => decodeFit(bytes(1, 2))).toThrow('not three curves')
})
