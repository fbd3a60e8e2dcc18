import { expect, test } from 'vitest'
import { PointTable } from '../points'
import { Rows, type StepNode, type View } from './rows'

const step = (path: string, parent: string | null, depth: number, loop = false): StepNode => ({
  path, parent, depth, loop, title: path.split('/').at(-1) ?? path,
})
const STEPS = [
  step('main/home', null, 0),
  step('main/scan', null, 0, true),
  step('main/scan/*/move', 'main/scan', 1),
  step('main/scan/*/shoot', 'main/scan', 1),
  step('finally/0', null, 0),
]
const VIEW: View = {
  closed: new Set(), openTables: new Set(), openPoints: new Map(), onlyProblems: false, find: '',
  isProblem: () => false,
}

function tables(size: number): Map<string, PointTable[]> {
  const table = new PointTable('main/scan')
  for (let i = 0; i < size; i++) table.set({ index: i, key: `${i},0`, status: i === 57 ? 'failed' : 'ok' })
  return new Map([['main/scan', [table]]])
}

const ids = (rows: Rows): string[] => rows.window(0, rows.size).map(({ row }) => row.id)

test('the points of a loop come after its steps, as one closed row', () => {
  expect(ids(new Rows(STEPS, tables(100), VIEW))).toEqual([
    'main/home', 'main/scan', 'main/scan/*/move', 'main/scan/*/shoot', 'main/scan/*', 'finally/0',
  ])
})

test('an open loop of 100,000 points has a row for each, without making them', () => {
  const rows = new Rows(STEPS, tables(100_000), { ...VIEW, openTables: new Set(['main/scan']) })

  expect(rows.size).toBe(100_006)
  expect(rows.at(5 + 99_999)).toMatchObject({ kind: 'point', index: 99_999 })
  expect(rows.at(100_005)).toMatchObject({ id: 'finally/0' })
  expect(rows.at(100_006)).toBeUndefined()
  expect(rows.indexOf('main/scan#412')).toBe(5 + 412)
})

test('an opened point has its lines below it', () => {
  const openPoints = new Map([['main/scan', new Map([[1, 2]])]])
  const rows = new Rows(STEPS, tables(3), { ...VIEW, openTables: new Set(['main/scan']), openPoints })

  expect(ids(rows).slice(5)).toEqual([
    'main/scan#0', 'main/scan#1', 'main/scan#1.0', 'main/scan#1.1', 'main/scan#2', 'finally/0',
  ])
})

test('a closed loop hides its steps and its points', () => {
  expect(ids(new Rows(STEPS, tables(9), { ...VIEW, closed: new Set(['main/scan']) }))).toEqual([
    'main/home', 'main/scan', 'finally/0',
  ])
})

test('only problems shows the steps and points in which something went wrong', () => {
  const isProblem = (path: string): boolean => path.endsWith('shoot')
  const rows = new Rows(STEPS, tables(100), { ...VIEW, onlyProblems: true, isProblem })

  expect(ids(rows)).toEqual(['main/scan/*/shoot', 'main/scan/*', 'main/scan#57'])
})

test('find looks in titles and in keys', () => {
  expect(ids(new Rows(STEPS, tables(60), { ...VIEW, find: 'shoot' }))).toEqual(['main/scan/*/shoot'])
  expect(ids(new Rows(STEPS, tables(60), { ...VIEW, find: '57,' }))).toEqual(['main/scan/*', 'main/scan#57'])
})
