import { afterEach, beforeEach, expect, it, vi } from 'vitest'
import { createApp, nextTick, ref } from 'vue'
import JogPad from './JogPad.vue'

const jogging = { said: ref(''), sending: ref(false), moving: ref(false), step: vi.fn(), hold: vi.fn(), letGo: vi.fn() }
vi.mock('./jogging', () => ({ useJogging: () => jogging }))
vi.mock('../../app/session', () => ({ useSession: () => ({ all: null }) }))

let root: HTMLElement
let app: ReturnType<typeof createApp>

async function pad(several: boolean, mode: 'step' | 'hold'): Promise<void> {
  root = document.body.appendChild(document.createElement('div'))
  app = createApp(JogPad, { device: 'gantry', axes: ['x', 'y', 'z'], several, feedMost: 2500, obstacle: '' })
  app.mount(root)
  if (mode === 'hold') root.querySelector<HTMLInputElement>('input[value=hold]')?.click()
  root.querySelector<HTMLButtonElement>('[role=switch]')?.click()
  await nextTick()
}
const press = (type: 'keydown' | 'keyup', ...keys: string[]): void => {
  for (const key of keys) window.dispatchEvent(new KeyboardEvent(type, { key }))
}

beforeEach(() => vi.useFakeTimers())
afterEach(() => {
  app.unmount()
  root.remove()
  vi.clearAllMocks()
  vi.useRealTimers()
})

it('two arrow keys held are one diagonal hold, and the one that stays down goes on alone', async () => {
  await pad(true, 'hold')
  press('keydown', 'ArrowRight', 'ArrowUp')
  vi.advanceTimersByTime(100)
  expect(jogging.hold.mock.calls).toEqual([[{ x: 1, y: 1 }, 1500]])

  press('keyup', 'ArrowUp')
  expect(jogging.letGo).toHaveBeenCalledTimes(1)
  vi.advanceTimersByTime(100)
  expect(jogging.hold.mock.lastCall).toEqual([{ x: 1 }, 1500])

  press('keyup', 'ArrowRight')
  vi.advanceTimersByTime(100)
  expect(jogging.letGo).toHaveBeenCalledTimes(2)
  expect(jogging.hold).toHaveBeenCalledTimes(2)
})

it('a key that is let go before the hold has begun moves nothing', async () => {
  await pad(true, 'hold')
  press('keydown', 'ArrowRight')
  press('keyup', 'ArrowRight')
  vi.advanceTimersByTime(100)

  expect(jogging.hold).not.toHaveBeenCalled()
})

it('a tap is a step, two keys together one diagonal step', async () => {
  await pad(true, 'step')
  press('keydown', 'ArrowLeft')
  press('keyup', 'ArrowLeft')
  vi.advanceTimersByTime(100)
  press('keydown', 'ArrowLeft', 'ArrowDown')
  vi.advanceTimersByTime(100)

  expect(jogging.step.mock.calls).toEqual([[{ x: -1 }, 1, 1500], [{ x: -1, y: -1 }, 1, 1500]])
})

it('a machine that moves one axis at a time has no diagonal buttons, and the newest key counts', async () => {
  await pad(false, 'hold')
  press('keydown', 'ArrowLeft', 'ArrowDown')
  vi.advanceTimersByTime(100)

  expect(root.querySelector('[aria-label="X+ Y+"]')).toBeNull()
  expect(jogging.hold.mock.calls).toEqual([[{ y: -1 }, 1500]])
})

it('a button that the space bar holds is let go with it', async () => {
  await pad(true, 'hold')
  root.querySelector('[aria-label="X+ Y-"]')?.dispatchEvent(new KeyboardEvent('keydown', { key: ' ', code: 'Space', bubbles: true }))
  expect(jogging.hold.mock.calls).toEqual([[{ x: 1, y: -1 }, 1500]])

  press('keyup', ' ')
  expect(jogging.letGo).toHaveBeenCalledTimes(1)
})
