import { expect, it } from 'vitest'

it('every store has an id of its own: of two with the same, a page gets the one that came first', () => {
  const texts = Object.values(import.meta.glob<string>('../**/*.ts', { query: '?raw', import: 'default', eager: true }))
  const ids = texts.flatMap((text) => [...text.matchAll(/= defineStore\('(\w+)'/g)].map((match) => match[1]))

  expect(ids.length).toBeGreaterThan(8)
  expect(ids).toEqual([...new Set(ids)])
})
