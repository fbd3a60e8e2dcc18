import { mount } from '@vue/test-utils'
import { expect, it } from 'vitest'
import OutlinePoints from './OutlinePoints.vue'

const CORE = [{ x: 0, y: 0 }, { x: 20, y: 0 }, { x: 20, y: 40 }, { x: 0, y: 40 }]
const shown = () => mount(OutlinePoints, { props: { outline: CORE } })
const press = (box: ReturnType<typeof shown>, words: string) => box.findAll('button').find((one) => one.text() === words)?.trigger('click')
async function used(box: ReturnType<typeof shown>): Promise<unknown> {
  await press(box, 'Use this outline')
  return box.emitted('use')?.at(-1)?.[0]
}

it('an outline that is right is used as it came', async () => {
  expect(await used(shown())).toEqual(CORE)
})

it('a point is typed, added after another and left out, never below three', async () => {
  const box = shown()
  await box.get('input[type=range]').setValue(1)
  await box.findAll('input[type=text]')[0]?.setValue('19,9')
  await box.findAll('input[type=text]')[1]?.setValue('over there')
  await press(box, 'Add a point after it')

  expect(await used(box)).toEqual([CORE[0], { x: 19.9, y: 0 }, { x: 20, y: 20 }, CORE[2], CORE[3]])

  for (let times = 0; times < 4; times++) await press(box, 'Leave it out')

  expect(await used(box)).toEqual([CORE[0], { x: 19.9, y: 0 }, CORE[3]])
})

it('the nearest point is dragged, and no farther than the picture', async () => {
  const box = shown()
  const area = box.get('svg')
  Object.assign(area.element, { getBoundingClientRect: () => ({ left: 100, top: 50, width: 320, height: 520 }), setPointerCapture: () => undefined })
  await area.trigger('pointerdown', { pointerId: 1, clientX: 355, clientY: 115 })
  await area.trigger('pointermove', { clientX: 260, clientY: 310 })

  expect(await used(box)).toEqual([CORE[0], CORE[1], { x: 10, y: 20 }, CORE[3]])

  await area.trigger('pointermove', { clientX: 9000, clientY: 310 })
  await area.trigger('pointerup')
  await area.trigger('pointermove', { clientX: 0, clientY: 0 })

  expect(await used(box)).toEqual([CORE[0], CORE[1], { x: 26, y: 20 }, CORE[3]])
})
