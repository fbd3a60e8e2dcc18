import { expect, it } from 'vitest'
import { sightOf } from './reach'

const device = { reach: 'online', word: 'idle', used_by: null, armed: null } as const

it('what is wrong, at work, armed and well are told apart by shape as well as by colour', () => {
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
