import { afterEach, beforeEach, expect, test, vi } from 'vitest'
import { Announcer } from './announce'

beforeEach(() => void vi.useFakeTimers())
afterEach(() => void vi.useRealTimers())

test('the first text is announced at once, later ones after five seconds, and only the newest', () => {
  const said: string[] = []
  const announcer = new Announcer((words) => said.push(words))
  announcer.tell('1 of 9')
  vi.advanceTimersByTime(1000)
  announcer.tell('2 of 9')
  vi.advanceTimersByTime(1000)
  announcer.tell('3 of 9')
  vi.advanceTimersByTime(2900)

  expect(said).toEqual(['1 of 9'])
  vi.advanceTimersByTime(200)
  expect(said).toEqual(['1 of 9', '3 of 9'])
})

test('the same text is not announced again', () => {
  const said: string[] = []
  const announcer = new Announcer((words) => said.push(words))
  announcer.tell('paused')
  vi.advanceTimersByTime(60_000)
  announcer.tell('paused')
  vi.advanceTimersByTime(60_000)

  expect(said).toEqual(['paused'])
})

test('nothing is announced after closing', () => {
  const said: string[] = []
  const announcer = new Announcer((words) => said.push(words))
  announcer.tell('a')
  announcer.tell('b')
  announcer.close()
  vi.advanceTimersByTime(60_000)

  expect(said).toEqual(['a'])
})
