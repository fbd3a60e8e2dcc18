import { expect, it } from 'vitest'
import type { RunSummary } from '../api/types'
import { lostSince, noticeOf } from './notify'

const run = (more: Partial<RunSummary>): RunSummary => ({ id: 'r', protocol: 'scan', live: true, fate: 'running', reason: '', questions: 0, ...more }) as RunSummary

it('an end, a failure with its reason and a question are news, and nothing else is', () => {
  const news = [
    noticeOf(run({}), run({ live: false, fate: 'succeeded' })),
    noticeOf(run({}), run({ live: false, fate: 'failed', reason: 'no plasma' })),
    noticeOf(run({}), run({ questions: 1 })),
    noticeOf(run({}), run({ done: 4 } as Partial<RunSummary>)),
    noticeOf(undefined, run({ live: false, fate: 'failed' })),
  ]

  expect(news).toEqual([
    { problem: false, text: '✓ scan is done' },
    { problem: true, text: 'scan failed: no plasma' },
    { problem: false, text: 'scan is waiting for you' },
    null,
    null,
  ])
})

it('a device that answered before and does not now is news', () => {
  expect(lostSince({ libs: 'online', gantry: 'online', camera: 'lost', scale: 'starting' }, { libs: 'lost', gantry: 'online', camera: 'lost', scale: 'lost', new: 'lost' })).toEqual(['libs'])
})
