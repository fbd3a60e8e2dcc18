// The effect of an edit on plain data, done the simple way: the reference for the patches in tests.
import type { Edit } from './edit'
import { isMap, type Path } from './path'
import { kindOf } from './steps'

type Bag = Record<string | number, unknown>

function holder(data: unknown, path: Path): Bag {
  let here = data as Bag
  for (const part of path.slice(0, -1)) here = here[part] as Bag
  return here
}

function list(data: unknown, path: Path): unknown[] {
  const bag = holder(data, path)
  const key = path.at(-1) ?? ''
  bag[key] ??= []
  return bag[key] as unknown[]
}

const HEADS: Record<string, [Bag, string]> = {
  parallel: [{}, 'parallel'], any: [{}, 'any'], foreach: [{ foreach: { item: [1, 2, 3] } }, 'steps'], repeat: [{ repeat: 2 }, 'steps'],
  while: [{ while: '${{ false }}', max: 10 }, 'steps'], if: [{ if: '${{ true }}' }, 'then'], steps: [{}, 'steps'],
}

/** The data after the edit; `duplicate` is judged without its new ids, and an ask without its text. */
export function meant(before: unknown, edit: Edit): unknown {
  const data = structuredClone(before)
  const at = edit.path.at(-1) as number
  const bag = holder(data, edit.path)
  const mine = (): unknown[] => bag as unknown as unknown[]
  switch (edit.kind) {
    case 'set': bag[at] = structuredClone(edit.value); break
    case 'drop': if (Array.isArray(bag)) bag.splice(at, 1); else Reflect.deleteProperty(bag, at); break
    case 'rename': bag[edit.name] = bag[at]; Reflect.deleteProperty(bag, at); break
    case 'insert': list(data, edit.path).splice(edit.index, 0, ...structuredClone(edit.values)); break
    case 'remove': mine().splice(at, 1); break
    case 'duplicate': mine().splice(at + 1, 0, structuredClone(mine()[at])); break
    case 'unwrap': {
      const step = mine()[at] as Bag
      const kind = kindOf(step) ?? ''
      mine().splice(at, 1, ...(step[kind === 'if' ? 'then' : kind === 'parallel' || kind === 'any' ? kind : 'steps'] as unknown[]))
      break
    }
    case 'move': move(data, mine(), at, list(data, edit.to), edit.index, String(edit.path.at(-2))); break
    case 'wrap': {
      const more = edit.more ?? 0
      if (edit.wrap === 'finally') move(data, mine(), at, list(data, ['finally']), ((data as Bag)['finally'] as unknown[]).length, String(edit.path.at(-2)))
      else if (edit.wrap === 'fallback') {
        const step = mine()[at] as Bag
        const tried = (step['fallback'] ??= []) as unknown[]
        if (more > 0) tried.push(...mine().splice(at + 1, more))
        else tried.push({ ask: '', choices: ['repeat', 'skip', 'stop'] })
      } else {
        const [head, key] = HEADS[edit.wrap] ?? [{}, 'steps']
        const inner = mine().splice(at, more + 1)
        mine().splice(at, 0, { ...structuredClone(head), [key]: inner })
      }
    }
  }
  return data
}

function move(data: unknown, from: unknown[], at: number, to: unknown[], index: number, key: string): void {
  const [step] = from.splice(at, 1)
  to.splice(from === to && index > at ? index - 1 : index, 0, step)
  if (from.length === 0 && ['on_resume', 'finally', 'else', 'fallback'].includes(key)) drop(data, from)
}

function drop(data: unknown, empty: unknown[]): void {
  for (const [key, value] of Object.entries(isMap(data) || Array.isArray(data) ? data : {})) {
    if (value === empty) Reflect.deleteProperty(data as Bag, key)
    else drop(value, empty)
  }
}
