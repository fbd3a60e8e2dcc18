import { expect, it } from 'vitest'
import { createApp, h, nextTick, ref } from 'vue'
import type { Place } from './axes'
import PositionPanel from './PositionPanel.vue'

async function typedKeyByKey(text: string, zero: Place): Promise<{ shown: string; aim: Place; root: HTMLElement; aimAt: (place: Place) => Promise<string> }> {
  const root = document.body.appendChild(document.createElement('div'))
  const aim = ref<Place>({ y: 3 })
  createApp({
    render: () => h(PositionPanel, {
      axes: ['x', 'y'], place: { x: 1, y: 2 }, zero, kept: true, ranges: { x: [0, 730] }, old: false, blocked: '',
      aim: aim.value, 'onUpdate:aim': (place: Place) => (aim.value = place),
    }),
  }).mount(root)
  const field = root.querySelector<HTMLInputElement>('input')
  if (!field) throw new Error('no field')
  for (const key of text) {
    field.value += key
    field.dispatchEvent(new Event('input'))
    await nextTick()
  }
  const aimAt = async (place: Place): Promise<string> => {
    aim.value = place
    await nextTick()
    return field.value
  }
  return { shown: field.value, aim: aim.value, root, aimAt }
}

it.each([['12.5', 112.5], ['12,5', 112.5], ['-5', 95], ['−5', 95], ['0.05', 100.05], ['3.10', 103.1], ['1e1', 110], ['7 mm', 107]])('%s typed key by key is where it says', async (text, x) => {
  const { shown, aim } = await typedKeyByKey(text, { x: 100 })

  expect(shown).toBe(text)
  expect(aim).toEqual({ x, y: 3 })
})

it('what is no number stays as typed, is told, and nothing goes', async () => {
  const { shown, aim, root } = await typedKeyByKey('ten', {})

  expect(shown).toBe('ten')
  expect(aim).toEqual({ y: 3 })
  expect(root.querySelector('[role=alert]')?.textContent).toBe('x: ten is not a number')
  expect(root.querySelector<HTMLButtonElement>('[type=submit]')?.disabled).toBe(true)
})

it('a place that is clicked takes the place of what was typed', async () => {
  const { aimAt } = await typedKeyByKey('12.50', {})

  expect(await aimAt({ x: 33.25, y: 3 })).toBe('33.25')
  expect(await aimAt({})).toBe('')
})
