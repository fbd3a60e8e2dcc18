import { expect, test } from 'vitest'
import type { RunDetail } from '../api/types'
import { holeAt, holeId, holesOf } from './holes'
import { RunPicture } from './picture'

test('of a hole with holes inside, only itself is offered', () => {
  const run = new RunPicture({ seq: 0, nodes: {}, loops: [{ path: 'main/cores' }, { path: 'main/cores/*/scan' }] } as unknown as RunDetail)
  run.table('main/cores').set({ index: 0, key: 'A', status: 'failed' })
  run.table('main/cores').set({ index: 1, key: 'B', status: 'ok' })
  for (const core of ['A', 'B']) {
    run.table('main/cores/*/scan', core).set({ index: 0, key: '0,0', status: 'ok' })
    run.table('main/cores/*/scan', core).set({ index: 1, key: '1,0', status: 'failed' })
  }

  const found = holesOf(run)

  expect(found.map(holeAt)).toEqual([
    { loop: 'main/cores', within: '', key: 'A' }, { loop: 'main/cores/*/scan', within: 'B', key: '1,0' },
  ])
  expect(new Set(found.map(holeId)).size).toBe(2)
})
