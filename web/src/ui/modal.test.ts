import { expect, it, vi } from 'vitest'
import { dialogClosed, dialogOpened } from './modal'

const click = (detail: number): boolean => document.body.dispatchEvent(new MouseEvent('click', { detail, bubbles: true, cancelable: true }))

it('the second click of a double click presses nothing where a dialog has opened or closed under it', () => {
  const time = vi.spyOn(performance, 'now').mockReturnValue(10_000)
  const close = (): void => undefined
  dialogOpened(close)

  expect([click(1), click(2)]).toEqual([true, false])

  time.mockReturnValue(11_000)

  expect(click(2)).toBe(true)

  dialogClosed(close)

  expect([click(1), click(2)]).toEqual([true, false])

  time.mockRestore()
})
