import { afterEach, expect, test, vi } from 'vitest'
import { effectScope, nextTick } from 'vue'
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
  await nextTick()

  expect(launch?.looking.value).toBe(true) // what was counted for 1 mm is not told of 0.5 mm

  await vi.advanceTimersByTimeAsync(5_000)

  expect(asked.filter((what) => what === 'check')).toHaveLength(2)
  expect(launch?.looking.value).toBe(false)
  scope.stop()
})

test('a check that does not come is asked for again, and what is typed stays', async () => {
  vi.useFakeTimers()
  let down = false
  vi.stubGlobal('fetch', (request: Request) => {
    const what = new URL(request.url).pathname.split('/')[3] ?? ''
    return down && what === 'check' ? Promise.reject(new TypeError('Failed to fetch')) : Promise.resolve(Response.json(ANSWERS[what]))
  })
  const scope = effectScope()
  const launch = scope.run(() => useLaunch(() => 'a.yaml'))
  await vi.advanceTimersByTimeAsync(1_000)
  down = true
  if (launch) launch.typed['pitch'] = '0,75'
  await vi.advanceTimersByTimeAsync(1_000)

  expect([launch?.failure.value === '', launch?.checked.value?.ok, launch?.params.value]).toEqual([false, true, { pitch: '0.75 mm' }])

  down = false
  await vi.advanceTimersByTimeAsync(6_000)

  expect([launch?.failure.value, launch?.typed['pitch']]).toEqual(['', '0,75'])
  scope.stop()
})
