import { expect, it } from 'vitest'
import { createApp, h, nextTick, ref } from 'vue'
import TextInput from './TextInput.vue'

it('what is being typed stays when the page shows something new around it; a new value replaces it', async () => {
  const root = document.body.appendChild(document.createElement('div'))
  const [value, around] = [ref('first'), ref(0)]
  const set: string[] = []
  createApp({ render: () => h(TextInput, { value: value.value, title: String(around.value), onSet: (text: string) => set.push(text) }) }).mount(root)
  const field = root.querySelector('input')
  if (!field) throw new Error('no field')
  field.value = 'too hi'
  field.dispatchEvent(new Event('input'))
  around.value++
  await nextTick()

  expect([field.title, field.value]).toEqual(['1', 'too hi'])

  field.dispatchEvent(new Event('change'))
  value.value = 'undone'
  await nextTick()

  expect(set).toEqual(['too hi'])
  expect(field.value).toBe('undone')
})
