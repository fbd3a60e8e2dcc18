import { beforeEach, expect, it } from 'vitest'
import { forgetTime, heardTime, serverNow } from './clock'

beforeEach(forgetTime)

it('the server’s time is taken from the fastest message', () => {
  heardTime(10_000, 1_000)
  heardTime(10_400, 1_500)
  heardTime(11_100, 2_150)

  expect(serverNow(2_200)).toBe(11_200)
})

it('old times no longer count, because clocks drift', () => {
  heardTime(10_000, 0)
  heardTime(100_000, 95_000)

  expect(serverNow(95_000)).toBe(100_000)
})

it('a server that has sent nothing is taken to have our time', () => {
  expect(serverNow(5)).toBe(5)
})
