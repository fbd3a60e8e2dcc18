import { afterEach, expect, test, vi } from 'vitest'
import { effectScope } from 'vue'
import { useDocument } from './document'

const KEY = 'labrun.draft:a.yaml'
const MINE = JSON.stringify({ base: 'r0', text: 'mine', at: '' })

afterEach(() => {
  vi.unstubAllGlobals()
  localStorage.clear()
})

test.each([[200, 'before'], [404, null]])('a draft of a file that others have saved since is a conflict before anybody can write (%i)', async (status, base) => {
  localStorage.setItem(KEY, MINE)
  vi.stubGlobal('fetch', (request: Request) => Promise.resolve(request.url.includes('/versions/r0')
    ? Response.json({ text: 'before', code: 'E', message: '' }, { status })
    : Response.json({ name: 'a.yaml', text: 'theirs', revision: 'r1', modified: '' })))
  const scope = effectScope()
  const file = scope.run(() => useDocument('a.yaml'))
  await file?.open()
  file?.write('mine')
  file?.keep()

  expect(file?.conflict.value).toEqual({ base, mine: 'mine', theirs: 'theirs', theirsRevision: 'r1' })
  expect(localStorage.getItem(KEY)).toBe(MINE)

  file?.settle()

  expect(localStorage.getItem(KEY)).toBe(null) // what is thrown away does not come back
  scope.stop()
})
