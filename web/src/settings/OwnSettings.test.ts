// Notifications: what the browser answered is said as it is, and what was put off can be asked again.
import { mount } from '@vue/test-utils'
import { createPinia } from 'pinia'
import { afterEach, expect, it, vi } from 'vitest'
import { nextTick } from 'vue'
import OwnSettings from './OwnSettings.vue'

afterEach(() => vi.unstubAllGlobals())

it('a permission that was put off is no block, and is asked for again', async () => {
  const answers = ['default', 'denied', 'granted']
  vi.stubGlobal('Notification', { permission: 'default', requestPermission: () => Promise.resolve(answers.shift()) })
  vi.stubGlobal('isSecureContext', true)
  const page = mount(OwnSettings, { global: { plugins: [createPinia()] } })
  const said = (): string => page.find('.said-warn').exists() ? page.get('.said-warn').text() : ''
  const settled = async (): Promise<void> => {
    await Promise.resolve()
    await nextTick()
  }

  expect(said()).toBe('')

  await page.findAll('input[type=checkbox]').at(-1)?.setValue(true)
  await settled()

  expect(said()).toBe('The browser has not been allowed to show notifications yet. Ask again')

  await page.get('.said-warn button').trigger('click')
  await settled()

  expect(said()).toBe('The browser blocks notifications for this page: allow them in its settings.')
})
