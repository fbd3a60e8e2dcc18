import { expect, test } from 'vitest'
import { emptyProtocol, fileName } from './library'

test('a file has the name that was typed, as far as a run can have it', () => {
  const made = ['grid scan', 'grid scan.yml', 'sub/scan', 'Ñandú', 'Моя карта', '測試 2.json', '-x.', 'a'.repeat(200)].map(fileName)

  expect(made).toEqual(['grid_scan.yaml', 'grid scan.yml', 'sub/scan.yaml', 'Nandu.yaml', 'protocol.yaml', '2.json', 'x.yaml', `${'a'.repeat(80)}.yaml`])
})

test('an empty protocol keeps in its summary what its name cannot say', () => {
  expect(emptyProtocol('a.yaml', 'a')).toBe('labrun: 1\nname: a\nsteps: []\n')
  expect(emptyProtocol('p.yaml', 'p', 'Карта: 1')).toBe('labrun: 1\nname: p\nsummary: "Карта: 1"\nsteps: []\n')
})
