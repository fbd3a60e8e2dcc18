import { expect, test } from 'vitest'
import { RunPicture } from './picture'
import { pointName } from './pointName'
import { PointTable } from './points'
import { pointOf, tableFor, tableOfNow } from './tableFor'
import type { RunDetail } from '../api/types'

test('a point is counted from one and has its place', () => {
  const table = new PointTable('main/scan')
  table.set({ index: 412, key: '2,8', status: 'ok' })
  table.x[412] = 0.30000000000000004
  table.y[412] = 1.6

  expect(pointName(table, 412)).toBe('point 413 (0.3, 1.6)')
})

test('a point without a place has its key, and its iteration of the loop around it', () => {
  const table = new PointTable('main/samples/*/shots', 'A')
  table.set({ index: 0, key: 'first', status: 'ok' })
  table.set({ index: 1, key: '1', status: 'ok' })

  expect(pointName(table, 0)).toBe('A · point 1 first')
  expect(pointName(table, 1)).toBe('A · point 2')
})

test('the map shows the innermost loop that something happens in, and afterwards the largest', () => {
  const outer = new PointTable('main/samples')
  const inner = new PointTable('main/samples/*/scan', 'A')
  for (let i = 0; i < 3; i++) outer.set({ index: i, key: `s${i}`, status: i ? 'waiting' : 'running' })
  for (let i = 0; i < 2; i++) inner.set({ index: i, key: String(i), status: 'running' })

  expect(tableOfNow([outer, inner])).toBe(inner)

  inner.settle()
  outer.settle()

  expect(tableOfNow([inner, outer])).toBe(outer)
  expect(tableOfNow([])).toBeNull()
})

test('a log line finds its point by loop and key, an address by number and table', () => {
  const run = new RunPicture({ id: 'r', seq: 0, nodes: {}, loops: [] } as unknown as RunDetail)
  run.table('main/scan').set({ index: 7, key: '7,0', status: 'ok' })

  expect(pointOf(run, 'main/scan', '7,0')?.index).toBe(7)
  expect(pointOf(run, 'main/scan', '9,9')).toBeNull()
  expect(tableFor(run, undefined)?.loop).toBe('main/scan')
  expect(tableFor(run, 'main/other')).toBeNull()
})
