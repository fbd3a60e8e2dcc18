import { afterEach, beforeEach, expect, it } from 'vitest'
import { keepFocus } from './focus'

let end: () => void
beforeEach(() => {
  document.body.innerHTML = '<main id="main"><div><ul><li><button>a</button></li><li><button>b</button></li><li><button>c</button></li></ul><button>add</button></div></main>'
  end = keepFocus()
})
afterEach(() => {
  end()
  document.body.innerHTML = ''
})
const button = (words: string): HTMLButtonElement => {
  const found = [...document.querySelectorAll('button')].find((one) => one.textContent === words)
  if (found === undefined) throw new Error(words)
  return found
}
const settled = (): Promise<void> => new Promise((resolve) => setTimeout(() => setTimeout(resolve)))
/** happy-dom leaves the focus where it was. */
async function gone(words: string): Promise<void> {
  button(words).blur()
  button(words).closest('li')?.remove()
  await settled()
}

it('goes to what stands in the place of a row that is gone, and of the last one to what is beside the list', async () => {
  button('b').focus()
  await gone('b')

  expect(document.activeElement?.textContent).toBe('c')

  await gone('c')

  expect(document.activeElement?.textContent).toBe('a')

  await gone('a')

  expect(document.activeElement?.textContent).toBe('add')
})

it('comes back to a button that could not be used for a moment', async () => {
  button('b').focus()
  button('b').blur()
  button('b').disabled = true
  await settled()
  button('b').disabled = false
  await settled()

  expect(document.activeElement?.textContent).toBe('b')
})

it('comes back from a dialog to a button that cannot be used yet, and may be gone then', async () => {
  button('b').focus()
  document.body.insertAdjacentHTML('beforeend', '<div role="dialog"><button>yes</button></div>')
  button('yes').focus()
  button('b').disabled = true
  button('yes').blur()
  document.querySelector('[role=dialog]')?.remove()
  await settled()
  button('b').disabled = false
  await settled()

  expect(document.activeElement?.textContent).toBe('b')

  await gone('b')

  expect(document.activeElement?.textContent).toBe('c')
})

it('lets the focus go on from what changes when it is left', async () => {
  button('a').focus()
  button('a').blur()
  document.getElementById('main')?.append('changed')
  for (let turn = 0; turn < 5; turn++) await Promise.resolve()

  expect(document.activeElement).toBe(document.body)

  button('b').focus()
  await settled()

  expect(document.activeElement?.textContent).toBe('b')
})

it('stays away when somebody clicked beside everything, and when the whole page is another', async () => {
  button('b').focus()
  document.body.dispatchEvent(new Event('pointerdown', { bubbles: true }))
  await gone('b')

  expect(document.activeElement).toBe(document.body)

  button('a').focus()
  button('a').blur()
  document.getElementById('main')?.replaceChildren(document.createElement('button'))
  await settled()

  expect(document.activeElement).toBe(document.body)
})

it('keys open a list in which nothing is chosen yet, and leave another one to the browser', () => {
  document.body.innerHTML = '<select><option value="">add…</option><option>x</option><option>y</option></select>'
  const list = document.querySelector('select')
  if (list === null) throw new Error('no list')
  let opened = 0
  list.showPicker = () => (opened += 1)
  const press = (key: string): boolean => list.dispatchEvent(new KeyboardEvent('keydown', { key, bubbles: true, cancelable: true }))

  expect([press('ArrowDown'), press('x'), press('Tab'), opened]).toEqual([false, false, true, 2])

  list.value = 'x'

  expect([press('ArrowDown'), opened]).toEqual([true, 2])
})
