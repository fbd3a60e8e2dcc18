import { flushPromises, mount } from '@vue/test-utils'
import { createPinia, setActivePinia } from 'pinia'
import { afterEach, beforeEach, expect, it, vi } from 'vitest'
import { useSession } from '../app/session'
import type { AllSettings } from '../api/types'
import LivePicture from './LivePicture.vue'

let looks: string[] = []
let scroll: (seen: readonly { isIntersecting: boolean }[]) => void
beforeEach(() => {
  looks = []
  vi.useFakeTimers()
  setActivePinia(createPinia())
  useSession().all = { settings: { look_every_s: 2, look_for_min: 0.1 } } as unknown as AllSettings
  vi.stubGlobal('IntersectionObserver', class {
    constructor(told: typeof scroll) { scroll = told }
    observe(): void { scroll([{ isIntersecting: true }]) }
    disconnect(): void { scroll = () => undefined }
  })
  vi.stubGlobal('fetch', async (request: Request) => {
    looks.push(new URL(request.url, 'http://bench').pathname)
    return Promise.resolve(new Response(new Blob(['seen']), { headers: { 'content-type': 'image/jpeg' } }))
  })
})
afterEach(() => {
  vi.unstubAllGlobals()
  vi.useRealTimers()
})

async function pass(seconds: number): Promise<void> {
  await vi.advanceTimersByTimeAsync(seconds * 1000)
  await flushPromises()
}

it('a camera is looked through while somebody looks, and for as long as the settings say', async () => {
  const shown = mount(LivePicture, { props: { cameras: ['eye'] }, attachTo: document.body })
  const fold = shown.get('details')
  const open = async (is: boolean): Promise<void> => {
    ;(fold.element as HTMLDetailsElement).open = is
    await fold.trigger('toggle')
    await pass(0)
  }
  await pass(10)

  expect(looks).toEqual([])

  await open(true)
  await pass(3)

  expect(looks).toEqual(Array(2).fill('/api/v1/devices/eye/picture'))

  await open(false)
  await pass(60)

  expect(looks.length).toBe(2)

  await open(true)
  await pass(60)

  expect(looks.length).toBe(2 + 4) // at 0, 2, 4 and 6 s of 6
  expect(shown.text()).toContain('The live picture ended after 0.1 min.')

  await shown.findAll('button').find((one) => one.text() === 'Look again')?.trigger('click')
  await pass(1)

  expect(looks.length).toBe(7)

  scroll([{ isIntersecting: false }])
  await pass(3)

  expect(looks.length).toBe(7)

  scroll([{ isIntersecting: true }])
  await pass(0)

  expect(looks.length).toBe(8)

  shown.unmount()
  await pass(60)

  expect(looks.length).toBe(8)
})
