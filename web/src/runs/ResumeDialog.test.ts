import { createPinia } from 'pinia'
import { afterEach, expect, test, vi } from 'vitest'
import { createApp } from 'vue'
import type { RunDetail } from '../api/types'
import { RunPicture } from './picture'
import ResumeDialog from './ResumeDialog.vue'

const NAMES = ['a.yaml', 'ab.yaml']
const changes = (text: string): object => ({ can_resume: true, same_text: false, diff: [text], agreeing: 1, reopened: 0, different: [], in_the_way: [], doubtful: [] })

afterEach(() => vi.unstubAllGlobals())

test('what is said of a protocol is of the one that is chosen, whichever answer comes last', async () => {
  const answers: Record<string, (text: string) => void> = {}
  vi.stubGlobal('fetch', async (request: Request) => {
    const what = new URL(request.url).pathname.split('/').at(-1)
    if (what === 'settings') return Response.json({ settings: { checklists: {}, operators: [] } })
    if (what === 'protocols') return Response.json(NAMES.map((name) => ({ name })))
    const { protocol } = (await request.json()) as { protocol: string }
    return new Promise((resolve) => (answers[protocol] = (text) => resolve(Response.json(changes(text)))))
  })
  const detail = { id: 'r1', seq: 1, nodes: {}, loops: [], outline: [], file: '', done: 0, holes: 0 } as unknown as RunDetail
  const app = createApp(ResumeDialog, { run: new RunPicture(detail), version: 0, how: 'changed' })
  app.use(createPinia()).mount(document.body.appendChild(document.createElement('div')))
  await vi.waitFor(() => expect(document.querySelectorAll('[role=dialog] option')).toHaveLength(2))
  const select = document.querySelector<HTMLSelectElement>('[role=dialog] select')
  for (const name of NAMES) {
    if (select) select.value = name
    select?.dispatchEvent(new Event('change'))
    await vi.waitFor(() => expect(answers[name]).toBeDefined())
  }

  expect(document.querySelector('[role=dialog] [role=status]')?.textContent).toBe('Comparing it with what was done…')

  answers['ab.yaml']?.('+ of the second')
  answers['a.yaml']?.('+ of the first')
  await vi.waitFor(() => expect(document.querySelector('[role=dialog] pre')).not.toBeNull())
  await new Promise((resolve) => setTimeout(resolve))

  expect(document.querySelector('[role=dialog] pre')?.textContent.trim()).toBe('+ of the second')
  app.unmount()
})
