// The names that an expression may use: parameters, steps before it, loop names, run.
import { isMap } from '../text/path'
import { kindOf } from '../text/steps'

export interface Name {
  name: string
  detail: string
}

export function namesIn(data: unknown): Name[] {
  if (!isMap(data)) return []
  const params = isMap(data['params']) ? Object.entries(data['params']) : []
  const found: Name[] = params.map(([name, param]) => ({ name: `params.${name}`, detail: isMap(param) ? shortly(param['default'] ?? param['type']) : '' }))
  const seen = new Set<string>()
  gather(data['steps'], (name, detail) => {
    if (!seen.has(name)) found.push({ name, detail })
    seen.add(name)
  })
  return [...found, { name: 'run.simulated', detail: 'true on the simulated lab' }, { name: 'run.id', detail: 'the name of the run' }]
}

function gather(data: unknown, tell: (name: string, detail: string) => void): void {
  if (Array.isArray(data)) data.forEach((one) => gather(one, tell))
  if (!isMap(data)) return
  const kind = kindOf(data)
  if (typeof data['id'] === 'string') tell(`steps.${data['id']}`, kind ?? '')
  if (kind === 'foreach' && isMap(data['foreach'])) {
    for (const [name, items] of Object.entries(data['foreach'])) {
      tell(name, 'of the loop')
      if (typeof items === 'string' && /grid\(/.test(items)) for (const field of ['x', 'y', 'ix', 'iy', 'index']) tell(`${name}.${field}`, 'of the grid')
    }
  }
  if (kind === 'set' && isMap(data['set'])) for (const name of Object.keys(data['set'])) tell(name, 'set by a step')
  for (const value of Object.values(data)) gather(value, tell)
}

function shortly(value: unknown): string {
  const text = typeof value === 'string' ? value : JSON.stringify(value)
  return text.length > 30 ? `${text.slice(0, 29)}…` : text
}
