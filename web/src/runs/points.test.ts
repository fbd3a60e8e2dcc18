import { expect, test } from 'vitest'
import { PointTable, type PointWindow } from './points'

function window(size: number): PointWindow {
  const all = Array.from({ length: size }, (_, i) => i)
  return {
    total: size, index: all, key: all.map((i) => (i < 2 ? `${i},0` : null)),
    status: all.map((i) => (i < 2 ? 'ok' : 'waiting')), x_mm: all.map((i) => i * 0.2), y_mm: all.map(() => 0),
    seconds: all.map((i) => (i < 2 ? 1.5 : null)), tries: all.map(() => 0), message: all.map(() => ''),
  }
}

test('points that wait have places already, and a change fills one in', () => {
  const table = new PointTable('main/scan')
  table.load(window(5))
  table.set({ index: 2, key: '2,0', status: 'failed', tries: 2, message: 'no plasma' })

  expect([0, 1, 2, 3].map((i) => table.status(i))).toEqual(['ok', 'ok', 'failed', 'waiting'])
  expect(table.x[4]).toBeCloseTo(0.8)
  expect(table.message(2)).toBe('no plasma')
  expect(table.indexOf('2,0')).toBe(2)
  expect(table.problems()).toEqual([2])
  expect([table.count('ok'), table.count('failed'), table.count('waiting')]).toEqual([2, 1, 2])
})

test('what was under way when a run ended is cancelled', () => {
  const table = new PointTable('main/scan')
  table.set({ index: 0, key: 'a', status: 'ok' })
  table.set({ index: 1, key: 'b', status: 'running' })
  table.settle()

  expect([table.status(0), table.status(1)]).toEqual(['ok', 'cancelled'])
  expect([table.count('running'), table.count('cancelled')]).toEqual([0, 1])
})

test('a loop of unknown length grows', () => {
  const table = new PointTable('main/hunt')
  for (let i = 0; i < 300; i++) table.set({ index: i, key: String(i), status: 'ok' })

  expect(table.size).toBe(300)
  expect(table.status(299)).toBe('ok')
  expect(table.status(0)).toBe('ok')
})

test('a point whose index becomes known later is not there twice', () => {
  const table = new PointTable('main/scan')
  table.set({ index: 0, key: 'b', status: 'running' })
  table.set({ index: 1, key: 'b', status: 'ok' })

  expect(table.status(0)).toBe('waiting')
  expect(table.keys[0]).toBeNull()
  expect(table.indexOf('b')).toBe(1)
})

test('a point that was tried again counts as a problem though it went well', () => {
  const table = new PointTable('main/scan')
  table.set({ index: 0, key: 'a', status: 'ok', tries: 1 })

  expect(table.problems()).toEqual([0])
})
