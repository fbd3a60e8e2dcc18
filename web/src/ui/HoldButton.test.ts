import { mount } from '@vue/test-utils'
import { expect, test, vi } from 'vitest'
import HoldButton from './HoldButton.vue'

test('is held by a pointer or a key for its time; shorter, it is clicked once', async () => {
  vi.useFakeTimers({ toFake: ['requestAnimationFrame', 'cancelAnimationFrame', 'performance'] })
  const button = mount(HoldButton, { props: { seconds: 1 } })
  const told = () => [button.emitted('held')?.length ?? 0, button.emitted('clicked')?.length ?? 0]
  await button.trigger('pointerdown', { button: 0 })
  vi.advanceTimersByTime(1100)
  await button.trigger('pointerup')
  await button.trigger('click')

  expect(told()).toEqual([1, 0])
  await button.trigger('pointerdown', { button: 0 })
  await button.trigger('pointerup')
  await button.trigger('click')
  await button.trigger('pointerdown', { button: 2 })
  vi.advanceTimersByTime(1100)

  expect(told()).toEqual([1, 1])
  await button.trigger('keydown', { key: 'Enter' })
  await button.trigger('keyup', { key: 'Enter' })
  await button.trigger('keydown', { key: ' ' })
  vi.advanceTimersByTime(1100)
  await button.trigger('keyup', { key: ' ' })

  expect(told()).toEqual([2, 2])
  vi.useRealTimers()
})
