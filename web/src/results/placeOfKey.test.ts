import { expect, test } from 'vitest'
import type { RunDetail } from '../api/types'
import { RunPicture } from '../runs/picture'
import { keyOfPlace, placeOfKey } from './placeOfKey'

test('a full key leads to its iteration and its point', () => {
  const run = new RunPicture({ id: 'r', seq: 0, nodes: {}, loops: [] } as unknown as RunDetail)
  run.table('main/samples/*/scan', 'A').set({ index: 3, key: '0,3', status: 'ok' })
  run.table('main/samples/*/scan', 'B').set({ index: 5, key: '0,3', status: 'ok' })

  expect(placeOfKey(run, 'main/samples/*/scan', 'B/0,3')).toMatchObject({ index: 5, table: { within: 'B' } })
  expect(keyOfPlace(run.table('main/samples/*/scan', 'B'), 5)).toBe('B/0,3')
  expect(placeOfKey(run, null, 'A/0,3')?.index).toBe(3)
  expect(placeOfKey(run, 'main/samples/*/scan', '0,3')).toBeNull()
})
