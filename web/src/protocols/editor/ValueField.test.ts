import { expect, it } from 'vitest'
import { createApp, h, nextTick, ref, type VNode } from 'vue'
import type { Field } from './fields'
import NewName from './NewName.vue'
import ValueField from './ValueField.vue'

const FIELD: Field = { name: 'items', kind: 'list', unit: '', choices: [], required: true, about: '', placeholder: '' }

function shown(render: () => VNode): HTMLElement {
  const root = document.body.appendChild(document.createElement('div'))
  createApp({ render }).mount(root)
  return root
}
/** A field of a value that only `kept` changes; a refusal leaves it. */
function fieldOf(first: unknown, field: Partial<Field>, kept: (value: unknown) => unknown) {
  const value = ref(first)
  const root = shown(() => h(ValueField, { field: { ...FIELD, ...field }, value: value.value, onSet: (now: unknown) => (value.value = kept(now)) }))
  return { root, value, input: root.querySelector('input') }
}
async function typed(input: HTMLInputElement | null, text: string): Promise<HTMLInputElement> {
  if (!input) throw new Error('no field')
  input.value = ''
  for (const key of text) {
    input.value += key
    input.dispatchEvent(new Event('input'))
    await nextTick()
  }
  if (!text) input.dispatchEvent(new Event('input'))
  return input
}
async function left(input: HTMLInputElement): Promise<string> {
  input.dispatchEvent(new Event('change'))
  await nextTick()
  await nextTick()
  return input.value
}

it.each([
  ['number', 'mm', '12,5', '12.5 mm'], ['number', 'mm', '−3', '-3 mm'], ['number', 's', '1,5 min', '1.5 min'], ['list', '', '007, "B, C", 3', ['007', 'B, C', 3]],
  ['list', '', '0,5', [0.5]], ['list', '', '0,5; 1,5 mm;2', [0.5, '1.5 mm', 2]], ['list', '', '0,5, 1,5 mm', [0.5, '1.5 mm']], ['list', '', '1,2,3', [1, 2, 3]], ['list', '', 'A,B;C', ['A,B', 'C']],
  ['list', '', '"a; b", c', ['a; b', 'c']], ['list', '', '1,2-dichloroethane', [1, '2-dichloroethane']], ['list', '', '1,2-dichloroethane; water', ['1,2-dichloroethane', 'water']], ['list', '', '0,5;', [0.5]],
  ['value', '', '5', 5], ['value', '', '0,5', 0.5], ['value', '', '1,5 mm', '1.5 mm'], ['value', '', '"5"', '5'], ['value', '', 'true', true], ['value', '', 'one, two', 'one, two'], ['value', '', '007', '007'],
] as const)('%s in “%s”: %s is kept as it is meant', async (kind, unit, text, meant) => {
  const { value, input } = fieldOf(undefined, { kind, unit }, (now) => now)
  await left(await typed(input, text))

  expect(value.value).toEqual(meant)
})

it('what is understood of a list is said while it is typed, and what was a text becomes a number', async () => {
  const { root, input } = fieldOf(['A', 'B'], {}, (now) => now)
  await typed(input, '0,5,1')

  expect(root.querySelector('[role=status]')?.textContent).toBe('3 items: 0 · 5 · 1')

  await typed(input, '0,5')

  expect(root.querySelector('[role=status]')?.textContent).toBe('1 item: 0.5')
  expect([await left(input as HTMLInputElement), root.querySelector('[role=status]')]).toEqual(['0.5', null])

  const { value, input: single } = fieldOf('to be measured', { kind: 'value' }, (now) => now)
  await left(await typed(single, '12,5'))

  expect([value.value, single?.value]).toEqual([12.5, '12.5'])
  value.value = '12'
  await nextTick()

  expect(single?.value).toBe('"12"')
})

it('what is being typed into a list stays when the protocol is read anew', async () => {
  const { value, input } = fieldOf(['A', 'B'], {}, (now) => now)
  await typed(input, 'A, B, C')
  value.value = ['A', 'B']
  await nextTick()

  expect(input?.value).toBe('A, B, C')
})

it('a value longer than a line of the form is shown whole, and Enter keeps it in one line', async () => {
  document.body.replaceChildren()
  const { root, value } = fieldOf('${{ params.x0 + point.x * params.pitch }}', { kind: 'number' }, (now) => now)
  const area = root.querySelector('textarea')
  if (!area) throw new Error('no area')
  area.focus()
  area.value = '${{ params.x0 +\n  point.x }}'
  area.dispatchEvent(new Event('input'))
  area.dispatchEvent(new KeyboardEvent('keydown', { key: 'Enter', cancelable: true }))
  await nextTick()
  await nextTick()

  expect(value.value).toBe('${{ params.x0 + point.x }}')
  expect(document.activeElement).toBe(root.querySelector('input'))
  expect([root.querySelector('textarea'), root.querySelector('input')?.value]).toEqual([null, '${{ params.x0 + point.x }}'])
})

it('what cannot be empty is shown as it still is', async () => {
  const { input } = fieldOf(['A', 'B'], {}, (now) => now ?? ['A', 'B'])

  expect(await left(await typed(input, ''))).toBe('A, B')
})

it.each([[[['nested'], 1]], [[true, 'A']], [{ a: 1 }]])('what the field would not give back as it is, is not to be written there: %j', (value) => {
  const { root, input } = fieldOf(value, {}, (now) => now)

  expect(input).toBe(null)
  expect(root.querySelector('button')?.textContent).toBe('edit in YAML')
})

it('a name that is there already is not written over', async () => {
  const added: string[] = []
  const root = shown(() => h(NewName, { label: 'New', hint: '', taken: ['pitch'], onAdd: (name: string) => added.push(name) }))
  const submit = (): unknown => root.querySelector('form')?.dispatchEvent(new Event('submit'))
  await typed(root.querySelector('input'), 'pitch')
  submit()

  expect(root.querySelector('[role=alert]')?.textContent).toBe('There is pitch already.')

  await typed(root.querySelector('input'), 'pitch_2')
  submit()

  expect(added).toEqual(['pitch_2'])
})
