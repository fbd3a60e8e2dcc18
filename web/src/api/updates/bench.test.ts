import { describe, expect, it } from 'vitest'
import type { Patch, RunSummary } from '../types'
import { applyPatch, emptyBench } from './bench'

function patch(seq: number, more: Partial<Patch> = {}): Patch {
  return {
    seq, server_time_ms: 0, devices: {}, runs: {}, goals: {}, jogs: {}, launches: {}, control: null, ...more,
  }
}

const run = { id: 'r1', live: true } as RunSummary

describe('the bench from patches', () => {
  it('applies changes and drops what is gone', () => {
    const bench = { ...emptyBench(), seq: 4 }
    const taken = applyPatch(bench, patch(5, { runs: { r1: run } }))

    expect(taken).toBe(true)
    expect(bench.runs['r1']?.live).toBe(true)

    applyPatch(bench, patch(6, { runs: { r1: null } }))

    expect(bench.runs).toEqual({})
  })

  it('changes nothing if a patch is missing', () => {
    const bench = { ...emptyBench(), seq: 4 }
    const taken = applyPatch(bench, patch(6, { runs: { r1: run } }))

    expect(taken).toBe(false)
    expect(bench.runs).toEqual({})
    expect(bench.seq).toBe(4)
  })

  it('skips what the snapshot already contains', () => {
    const bench = { ...emptyBench(), seq: 9, runs: { r1: run } }
    const taken = applyPatch(bench, patch(8, { runs: { r1: null } }))

    expect(taken).toBe(true)
    expect(bench.runs['r1']).toBe(run)
  })
})
