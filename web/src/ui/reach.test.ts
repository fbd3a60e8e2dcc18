import { expect, it } from 'vitest'
import { sightOf } from './reach'

const device = { reach: 'online', word: 'idle', used_by: null, armed: null } as const

it('faulty, busy, armed and ready devices differ in shape as well as in colour', () => {
  const seen = [
    sightOf(device),
    sightOf({ ...device, word: 'moving' }),
    sightOf({ ...device, word: 'alarm' }),
    sightOf({ ...device, armed: 'Ada' }),
    sightOf({ ...device, reach: 'lost' }),
    sightOf({ ...device, reach: 'starting' }),
  ]

  expect(new Set(seen.map((one) => one.shape)).size).toBe(6)
  expect(seen.map((one) => one.tone)).toEqual(['ok', 'accent', 'fail', 'warn', 'fail', 'muted'])
})
