import { mount } from '@vue/test-utils'
import { createPinia } from 'pinia'
import { afterEach, expect, test, vi } from 'vitest'
import type { RunDetail } from '../api/types'
import Commands from './Commands.vue'
import { RunPicture } from './picture'

afterEach(() => vi.unstubAllGlobals())

test('what was answered to a pause stays while it is paused, and not when somebody else lets it go on', async () => {
  vi.stubGlobal('fetch', async () => Response.json({ text: 'paused: running actions finish, then the run holds' }))
  const detail = { id: 'r1', seq: 1, nodes: {}, loops: [], outline: [], live: true, fate: 'running' } as unknown as RunDetail
  const run = new RunPicture(detail)
  const shown = mount(Commands, { props: { run, version: 0 }, global: { plugins: [createPinia()] } })
  const becomes = async (fate: string, version: number): Promise<boolean> => {
    run.head = { ...run.head, fate } as typeof run.head
    await shown.setProps({ version })
    return shown.text().includes('then the run holds')
  }
  await shown.get('[aria-expanded]').trigger('click')
  await shown.get('.choices button').trigger('click')
  await vi.waitFor(() => expect(shown.text()).toContain('then the run holds'))

  expect([await becomes('paused', 1), await becomes('running', 2)]).toEqual([true, false])
})
