import { expect, it } from 'vitest'
import type { RunSummary } from '../api/types'
import { newsOf } from './telling'

const run = (more: Partial<RunSummary>): RunSummary => ({ id: 'r', protocol: 'scan', live: true, fate: 'running', reason: '', questions: 0, ...more }) as RunSummary

it('an end is news, a failure with its reason, a question, and nothing else', () => {
  const news = [
    newsOf(run({}), run({ live: false, fate: 'succeeded' })),
    newsOf(run({}), run({ live: false, fate: 'failed', reason: 'no plasma' })),
    newsOf(run({}), run({ questions: 1 })),
    newsOf(run({}), run({ done: 4 } as Partial<RunSummary>)),
    newsOf(undefined, run({ live: false, fate: 'failed' })),
  ]

  expect(news).toEqual([
    { problem: false, text: '✓ scan is done' },
    { problem: true, text: 'scan failed: no plasma' },
    { problem: false, text: 'scan waits for you' },
    null,
    null,
  ])
})
