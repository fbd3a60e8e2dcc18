import { expect, test } from 'vitest'
import { classColour, classesIn, drawClasses } from './classes'

test('each class has its colour, a point without one is a hole', () => {
  const { data } = drawClasses(new Float32Array([1, NaN, 2, 1]), 2, 2)

  expect([...data.slice(8, 12)]).toEqual([0, 114, 178, 255])
  expect([...data.slice(12, 16)]).toEqual([0, 0, 0, 0])
  expect([...data.slice(0, 4)]).toEqual([230, 159, 0, 255])
})

test('the ninth class has the first colour again', () => {
  expect(classColour(9)).toBe(classColour(1))
})

test('classes are counted', () => {
  expect(classesIn(new Float32Array([2, 1, 2, NaN]))).toEqual([{ number: 1, count: 1 }, { number: 2, count: 2 }])
})
