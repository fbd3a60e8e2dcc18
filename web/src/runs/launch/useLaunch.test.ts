import { afterEach, expect, test, vi } from 'vitest'
import { effectScope } from 'vue'
import { useLaunch } from './useLaunch'

const PITCH = { name: 'pitch', type: 'quantity', unit: 'mm', default: '1 mm', default_text: '1 mm', required: false }
const ANSWERS: Record<string, unknown> = {
  protocols: { name: 'a.yaml', text: 'labrun: 1', revision: 'r' },
  settings: { settings: { checklists: {}, operators: [] } },
  check: { ok: true, params: [PITCH], roles: [], hazards: [], problems: [] },
  preview: { tracks: [], actions: {} },
}

afterEach(() => {
  vi.useRealTimers()
  vi.unstubAllGlobals()
})

test('a form is checked once, and again only when something else is typed', async () => {
  vi.useFakeTimers()
  const asked: string[] = []
  vi.stubGlobal('fetch', (request: Request) => {
    const what = new URL(request.url).pathname.split('/')[3] ?? ''
    asked.push(what)
    return Promise.resolve(Response.json(ANSWERS[what]))
  })
  const scope = effectScope()
  const launch = scope.run(() => useLaunch(() => 'a.yaml'))
  await vi.advanceTimersByTimeAsync(5_000)

  expect(asked.filter((what) => what === 'check')).toHaveLength(1)

  if (launch) launch.typed['pitch'] = '0.5'
  await vi.advanceTimersByTimeAsync(5_000)

  expect(asked.filter((what) => what === 'check')).toHaveLength(2)
  expect(launch?.looking.value).toBe(false)
  scope.stop()
})
