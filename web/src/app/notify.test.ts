import { mount } from '@vue/test-utils'
import { createPinia, setActivePinia } from 'pinia'
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest'
import { nextTick } from 'vue'
import { createMemoryHistory, createRouter } from 'vue-router'
import { useConnection } from '../api/updates/connection'
import type { RunSummary } from '../api/types'
import { lostSince, noticeOf, useNotifications } from './notify'
import { usePreferences } from './preferences'

const run = (more: Partial<RunSummary>): RunSummary => ({ id: 'r', protocol: 'scan', live: true, fate: 'running', reason: '', questions: 0, ...more }) as RunSummary

it('an end, a failure with its reason and a question are news, and nothing else is', () => {
  const news = [
    noticeOf(run({}), run({ live: false, fate: 'succeeded' })),
    noticeOf(run({}), run({ live: false, fate: 'succeeded', holes: 2 })),
    noticeOf(run({}), run({ live: false, fate: 'failed', reason: 'no plasma' })),
    noticeOf(run({}), run({ live: false, fate: 'aborted', reason: 'aborted by Ada' })),
    noticeOf(run({}), run({ live: false, fate: 'aborted', reason: 'stopped at once by Ada' })),
    noticeOf(run({}), run({ questions: 1 })),
    noticeOf(run({}), run({ done: 4 } as Partial<RunSummary>)),
    noticeOf(undefined, run({ live: false, fate: 'failed' })),
  ]

  expect(news).toEqual([
    { problem: false, text: '✓ scan is done' },
    { problem: false, text: '✓ scan is done, with 2 holes' },
    { problem: true, text: 'scan failed: no plasma' },
    { problem: true, text: 'scan aborted by Ada' },
    { problem: true, text: 'scan aborted: stopped at once by Ada' },
    { problem: false, text: 'scan is waiting for you' },
    null,
    null,
  ])
})

it('a device that answered before and does not now is news', () => {
  expect(lostSince({ libs: 'online', gantry: 'online', camera: 'lost', scale: 'starting' }, { libs: 'lost', gantry: 'online', camera: 'lost', scale: 'lost', new: 'lost' })).toEqual(['libs'])
})

describe('a notification of the system', () => {
  const shown: { body: string; tag: string; closed: boolean; onclick: () => void }[] = []
  const inView: { name: string }[] = []
  const router = createRouter({
    history: createMemoryHistory(), routes: ['/', '/runs/:run', '/devices/:device'].map((path) => ({ path, name: path.split('/')[1] === 'runs' ? 'run' : path.split('/')[1] || 'start', component: { template: '<p />' } })),
  })
  let end: () => void

  async function tell(more: Partial<RunSummary>): Promise<void> {
    useConnection().bench.runs = { ...useConnection().bench.runs, r: run(more) }
    await nextTick()
    await new Promise((resolve) => setTimeout(resolve))
  }

  beforeEach(async () => {
    localStorage.clear()
    setActivePinia(createPinia())
    shown.length = inView.length = 0
    class Shown {
      static permission = 'granted'
      closed = false
      onclick = (): void => undefined
      body: string
      tag: string
      constructor(_title: string, { body, tag }: { body: string; tag: string }) {
        this.body = body
        this.tag = tag
        shown.push(this)
      }

      close(): void {
        this.closed = true
      }
    }
    vi.stubGlobal('Notification', Shown)
    vi.stubGlobal('isSecureContext', true)
    vi.spyOn(document, 'hasFocus').mockReturnValue(false)
    Object.defineProperty(navigator, 'locks', { configurable: true, value: { query: () => Promise.resolve({ held: inView }), request: () => Promise.resolve() } })
    usePreferences().notifications = true
    await router.push('/')
    const page = mount({ template: '<p />', setup: () => { useNotifications() } }, { global: { plugins: [router] } })
    end = () => { page.unmount() }
    useConnection().bench.seq = 0
    await tell({})
  })
  afterEach(() => {
    end()
    vi.unstubAllGlobals()
    vi.restoreAllMocks()
  })

  it('opens its run by a click, and is gone when the question is answered', async () => {
    await tell({ questions: 1 })

    expect(shown.map(({ body, tag }) => [body, tag])).toEqual([['scan is waiting for you', 'r asks']])

    shown[0]?.onclick()
    await vi.waitFor(() => { expect(router.currentRoute.value.path).toBe('/runs/r') })
    await tell({ questions: 0 })

    expect(shown[0]?.closed).toBe(true)
  })

  it('comes of a run that asks at once, too, and of its end beside its question', async () => {
    useConnection().bench.runs = { ...useConnection().bench.runs, s: run({ id: 's', questions: 1 }) }
    await tell({ live: false, fate: 'succeeded' })

    expect(shown.map(({ tag }) => tag).sort()).toEqual(['r ends', 's asks'])
  })

  it('tells of devices that are lost together once, and not of one that is back', async () => {
    vi.useFakeTimers()
    const reach = (words: string): unknown => Object.fromEntries(['gantry', 'libs', 'scale'].map((name, i) => [name, { name, reach: words.split(' ')[i] }]))
    for (const words of ['online online online', 'lost online lost', 'lost lost lost', 'lost lost online']) {
      Object.assign(useConnection().bench, { devices: reach(words) })
      await nextTick()
    }
    await vi.runAllTimersAsync()
    vi.useRealTimers()

    expect(shown.map(({ body }) => body)).toEqual(['2 devices are lost: gantry, libs'])
  })

  it('does not come while a person has a tab of the page before them, nor unasked', async () => {
    inView.push({ name: 'labrun.in-view' })
    await tell({ questions: 1 })
    inView.length = 0
    usePreferences().notifications = false
    await tell({ live: false, fate: 'failed' })

    expect(shown).toEqual([])
  })
})
