import { expect, test } from 'vitest'
import { apart, keyRange, valueNear } from './plotOptions'

const whole = { min: 190, max: 950 }

test('plus and minus zoom about the middle, and never beyond the whole', () => {
  expect(keyRange('+', { min: 600, max: 700 }, whole)).toEqual({ min: 625, max: 675 })
  expect(keyRange('-', { min: 600, max: 700 }, whole)).toEqual({ min: 550, max: 750 })
  expect(keyRange('-', { min: 200, max: 900 }, whole)).toEqual(whole)
})

test('arrows move the visible range within the data', () => {
  expect(keyRange('ArrowRight', { min: 600, max: 700 }, whole)).toEqual({ min: 610, max: 710 })
  expect(keyRange('ArrowLeft', { min: 195, max: 295 }, whole)).toEqual({ min: 190, max: 290 })
  expect(keyRange('Home', { min: 195, max: 295 }, whole)).toEqual(whole)
  expect(keyRange('x', whole, whole)).toBeNull()
})

test('a zoom ends at ten channels', () => {
  const nm = Float64Array.from({ length: 22_800 }, (_, i) => 190 + i / 30)

  expect(apart(600, 700, nm)).toEqual([600, 700])
  expect(apart(600, 600.01, nm).map((at) => Number(at.toFixed(3)))).toEqual([599.838, 600.172])
})

test('a value is that of the nearest wavelength of its own axis, and none beyond it', () => {
  const nm = Float32Array.of(200, 201, 204)
  const values = Float32Array.of(1, 2, 3)

  expect([199, 200, 200.4, 203, 204, 205].map((at) => valueNear(nm, values, at))).toEqual([NaN, 1, 1, 3, 3, NaN])
})
