import { expect, test } from 'vitest'
import type { RunDetail, RunPatch } from '../api/types'
import { RunPicture } from './picture'

const loop = (path: string, placed: boolean) => ({
  path, title: path, total: 4, done: 0, succeeded: 0, failed: 0, skipped: 0, current: null, placed,
})
const detail = {
  id: 'r1', seq: 7, nodes: {}, loops: [loop('main/samples', false), loop('main/samples/*/scan', true)], done: 0,
} as unknown as RunDetail

function patch(seq: number, ...points: [string, string, number, string][]): RunPatch {
  return {
    run: 'r1', seq, head: { ...detail, done: seq }, nodes: { 'main/shoot': { status: 'failed', failed: 1 } },
    points: points.map(([at, within, index, key]) => ({
      loop: at, within, index, key, status: 'ok', seconds: 1, tries: 0, message: '',
    })),
  } as unknown as RunPatch
}

test('patches follow each other, and a gap is noticed', () => {
  const picture = new RunPicture(detail)

  expect(picture.take(patch(8))).not.toBeNull()
  expect(picture.head.done).toBe(8)
  expect(picture.take(patch(8))?.points.size).toBe(0)
  expect(picture.take(patch(10))).toBeNull()
  expect(picture.head.done).toBe(8)
})

test('a patch says which points are to be drawn again', () => {
  const picture = new RunPicture(detail)
  const change = picture.take(patch(8, ['main/samples/*/scan', 'A', 3, '0,3'], ['main/samples/*/scan', 'A', 0, '0,0']))

  expect(change?.points).toEqual(new Map([['main/samples/*/scan|A', [3, 0]]]))
  expect(change?.newTable).toBe(true)
  expect(picture.table('main/samples/*/scan', 'A').status(3)).toBe('ok')
})

test('inner loops have a table for each iteration, and those over the plane come first', () => {
  const picture = new RunPicture(detail)
  picture.take(patch(8, ['main/samples', '', 0, 'A'], ['main/samples/*/scan', 'A', 0, '0,0'], ['main/samples/*/scan', 'B', 0, '0,0']))

  expect(picture.filled().map((table) => table.id)).toEqual([
    'main/samples/*/scan|A', 'main/samples/*/scan|B', 'main/samples',
  ])
})

test('a step that failed once is a problem', () => {
  const picture = new RunPicture(detail)
  picture.take(patch(8))

  expect(picture.isProblem('main/shoot')).toBe(true)
  expect(picture.isProblem('main/home')).toBe(false)
})
