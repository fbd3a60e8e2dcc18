// What is under the pointer: an action's summary, a parameter's range, a key of the language.
import type { Extension } from '@codemirror/state'
import { hoverTooltip } from '@codemirror/view'
import { isMap, valueAt, type Path } from '../text/path'
import type { Place } from '../text/place'
import type { Read } from '../text/reading'
import { kindOf } from '../text/steps'
import { actionOf, keyText, resolve, type Contracts } from './contracts'
import { rangeText } from './fields'

export function hoverFor(read: () => Read | null, contracts: Contracts): Extension {
  return hoverTooltip((view, at) => {
    const now = read()
    if (!now?.root || now.text.length !== view.state.doc.length) return null
    const found = pairAt(now.root, at)
    const text = found && hoverText(now.data, found.path, found.onKey, contracts)
    if (!found || !text) return null
    return {
      pos: found.from, end: found.to, above: true,
      create: () => {
        const dom = document.createElement('div')
        dom.className = 'cm-hover-doc'
        dom.textContent = text
        return { dom }
      },
    }
  })
}

interface Under {
  path: Path
  onKey: boolean
  from: number
  to: number
}

function pairAt(root: Place, at: number): Under | null {
  let place = root
  const path: (string | number)[] = []
  for (;;) {
    const i = place.items.findIndex((one) => one.start <= at && at <= Math.max(one.end, one.keyEnd))
    const item = place.items[i]
    if (!item) return null
    path.push(item.key ?? i)
    if (item.key !== null && at <= item.keyEnd) return { path, onKey: true, from: item.start, to: item.keyEnd }
    if (item.value.items.length === 0) return item.value.kind === 'scalar' ? { path, onKey: false, from: item.value.from, to: item.value.to } : null
    place = item.value
  }
}

export function hoverText(data: unknown, path: Path, onKey: boolean, contracts: Contracts): string {
  const key = String(path.at(-1) ?? '')
  const parent = path.slice(0, -1)
  if (key === 'do' && !onKey) {
    const found = actionOf(contracts, data, valueAt(data, path))
    const danger = found?.action.danger
    return found ? `${found.action.summary}${danger ? ` (danger: ${danger})` : ''}` : ''
  }
  if (parent.at(-1) === 'with') {
    const found = actionOf(contracts, data, valueAt(data, [...parent.slice(0, -1), 'do']))
    const part = valueAt(found?.action.params, ['properties', key])
    return isMap(part) ? [part['description'], rangeText(part)].filter((one) => typeof one === 'string' && one !== '').join(' · ') : ''
  }
  if (!onKey) return ''
  const kind = kindOf(valueAt(data, parent))
  if (kind !== null) return keyText(contracts.schema, kind, key)
  const top = parent.length === 0 ? resolve(contracts.schema, valueAt(contracts.schema, ['properties', key])) : undefined
  return isMap(top) && typeof top['description'] === 'string' ? top['description'] : ''
}
