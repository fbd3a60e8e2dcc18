import { expect, test } from 'vitest'
import type { NodeState } from '../picture'
import { stateWords } from './rowWords'
import { actionWords } from './usePointLines'

const state = (more: Partial<NodeState>): NodeState =>
  ({ status: 'ok', running: 0, ok: 0, failed: 0, skipped: 0, unknown: 0, retries: 0, last_s: null, message: '', ...more })

test('a step in a loop counts its points, one outside does not', () => {
  expect(stateWords(state({ ok: 1, last_s: 21 }))).toEqual(['21 s', false])
  expect(stateWords(state({ ok: 1412, failed: 1, retries: 3, last_s: 6.1, message: 'no plasma' }))).toEqual([
    'no plasma · 1,412 ✓ 1 ✕ 3 ↻ · 6.1 s', true,
  ])
})

test('an attempt shows its number, its outcome, and why', () => {
  const words = actionWords({
    id: 'x', node: 'main/scan/*/shoot', line: 50, device: 'libs', action: 'measure', attempt: 2, params: {}, state: 'ABORTED',
    result: null, error: { name: 'NoPlasma', message: 'the sample did not ignite' }, sent_at: '', ended_at: '', seconds: 6.14, files: [],
  })

  expect(words).toMatchObject({
    status: 'failed', title: 'shoot · libs.measure (try 2)', more: 'NoPlasma: the sample did not ignite · 6.1 s',
  })
})
