// Drawing over the bench: a drag that ends outside the picture ends at its edge, and one that is cancelled draws nothing.
import { mount } from '@vue/test-utils'
import { createPinia } from 'pinia'
import { expect, test, vi } from 'vitest'
import { nextTick } from 'vue'
import PreviewMap from './PreviewMap.vue'

const track = { device: 'gantry', area: { x0: 0, x1: 100, y0: 0, y1: 100 }, allowed: { x0: 0, x1: 100, y0: 0, y1: 100 }, keep_out: [], outside: [], x_mm: [10], y_mm: [20], joined: [false], track: [0] } as never

test('a drag that leaves the picture ends at its edge, a cancelled one draws nothing', async () => {
  vi.stubGlobal('requestAnimationFrame', (work: () => void) => (work(), 0))
  const page = mount(PreviewMap, { props: { track, point: 0, lit: 0, corners: { x: 10, y: 20, width: 30, height: 40 }, drawing: true }, global: { plugins: [createPinia()], stubs: ['RouterLink'] } })
  const canvas = page.get('canvas')
  Object.assign(canvas.element, { setPointerCapture: () => undefined })
  const scale = (200 - 68) / 100 // of a picture 200 wide and 280 high, with room for its rulers
  const bottom = 280 - (280 - 100 * scale) / 2
  const drag = async (end: string): Promise<void> => {
    await canvas.trigger('pointerdown', { button: 0, clientX: 100, clientY: bottom - 10 * scale })
    await canvas.trigger('pointermove', { clientX: -5000, clientY: -5000 })
    await canvas.trigger(end, { clientX: -5000, clientY: -5000 })
    await nextTick()
  }
  await drag('pointercancel')

  expect(page.emitted('drawn')).toBe(undefined)

  await drag('pointerup')
  const [box] = page.emitted('drawn')?.[0] as [{ x: number; y: number; width: number; height: number }]

  expect(box.y).toBeCloseTo(10, 0)
  expect(box.y + box.height).toBeCloseTo(bottom / scale, 0)
  expect(box.width).toBeCloseTo(100 / scale, 0)
  vi.unstubAllGlobals()
})
