import { afterEach, expect, it, vi } from 'vitest'

afterEach(() => vi.unstubAllGlobals())

it('what a browser refuses to keep lasts as long as the page', async () => {
  const refuse = (): never => { throw new DOMException('Access is denied for this document.', 'SecurityError') }
  for (const name of ['localStorage', 'sessionStorage']) Object.defineProperty(window, name, { get: refuse, configurable: true })
  await import('./storage')
  localStorage.setItem('a', '1')
  sessionStorage.setItem('a', '2')
  sessionStorage.removeItem('a')

  expect([localStorage.getItem('a'), sessionStorage.getItem('a'), localStorage.getItem('b')]).toEqual(['1', null, null])
})
