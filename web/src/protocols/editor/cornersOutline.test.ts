import { flushPromises, mount } from '@vue/test-utils'
import { createPinia, setActivePinia } from 'pinia'
import { afterEach, beforeEach, expect, it, vi } from 'vitest'
import { useConnection } from '../../api/updates/connection'
import CornersOutline from './CornersOutline.vue'

const kept: unknown[] = []
beforeEach(() => {
  kept.length = 0
  setActivePinia(createPinia())
  vi.stubGlobal('fetch', async (request: Request) => {
    kept.push(await request.json())
    return Response.json({ name: 'outline_2.csv' })
  })
})
afterEach(() => vi.unstubAllGlobals())

const shown = () => mount(CornersOutline, { props: { name: 'core.yaml', device: 'gantry' }, global: { stubs: { RouterLink: true } } })

it('three places where the device was become an outline; the first two are kept while it is moved on another page', async () => {
  const { bench } = useConnection()
  const at = (x: number, y: number): unknown => Object.assign(bench.devices, { gantry: { name: 'gantry', status: { x, y } } })
  at(10, 0)
  const first = shown()
  await first.get('button').trigger('click')
  at(30, 20)
  await flushPromises()
  await first.get('button').trigger('click')

  expect(first.text()).toContain('Corner 2: x 30.00 y 20.00 mm')

  first.unmount()
  at(20, 30)
  const later = shown()

  expect(later.get('button').text()).toBe('Teach corner 3 of 3')

  await later.get('button').trigger('click')
  await flushPromises()

  expect(kept).toEqual([{ protocol: 'core.yaml', name: 'outline.csv', text: 'x (mm),y (mm)\n10,0\n30,20\n20,30\n0,10\n' }])
  expect(later.emitted('taken')).toEqual([['outline_2.csv', { x: 0, y: 0, width: 30, height: 30 }]])
  expect(later.get('button').text()).toBe('Teach corner 1 of 3')
})

it('in one line they are refused, and the third can be taught again', async () => {
  Object.assign(useConnection().bench.devices, { gantry: { name: 'gantry', status: { x: 1, y: 1 } } })
  const form = shown()
  for (let presses = 0; presses < 3; presses++) await form.get('button').trigger('click')

  expect(form.get('[role=alert]').text()).toBe('These three corners are in one line.')
  expect(form.get('button').text()).toBe('Teach corner 3 of 3')
  expect(kept).toEqual([])
})
