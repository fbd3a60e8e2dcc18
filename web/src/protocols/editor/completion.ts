// What may be written at the caret: keys, actions, parameters, values, and names in expressions.
import { yamlLanguage } from '@codemirror/lang-yaml'
import type { Completion, CompletionContext, CompletionResult } from '@codemirror/autocomplete'
import type { Extension } from '@codemirror/state'
import { isMap, valueAt } from '../text/path'
import { kindOf, STEP_KINDS } from '../text/steps'
import { contextAt, type Context } from './context'
import { actionOf, keyText, resolve, type Contracts } from './contracts'
import { rangeText } from './fields'
import { namesIn } from './names'

export function completionFor(data: () => unknown, contracts: Contracts): Extension {
  return yamlLanguage.data.of({ autocomplete: (context: CompletionContext) => complete(context, data(), contracts) })
}

function complete(context: CompletionContext, data: unknown, contracts: Contracts): CompletionResult | null {
  const line = context.state.doc.lineAt(context.pos)
  const before = line.text.slice(0, context.pos - line.from)
  const opened = before.lastIndexOf('${{')
  if (opened >= 0 && !before.slice(opened).includes('}}')) return inExpression(context, data)
  const word = context.matchBefore(/[\w.@/-]*$/)
  if (!word || (word.from === word.to && !context.explicit && !/[:-] $/.test(before))) return null
  const place = contextAt(context.state.doc, context.pos)
  const options = place.key === null ? keysFor(place, contracts, data) : valuesFor(place, contracts, data)
  return options.length > 0 ? { from: word.from, options, validFor: /^[\w.@/-]*$/ } : null
}

function inExpression(context: CompletionContext, data: unknown): CompletionResult | null {
  const word = context.matchBefore(/[A-Za-z_][\w.]*$/)
  if (!word && !context.explicit) return null
  const options = namesIn(data).map(({ name, detail }): Completion => ({ label: name, detail, type: 'variable' }))
  return { from: word?.from ?? context.pos, options, validFor: /^[\w.]*$/ }
}

function keysFor({ path, siblings }: Context, contracts: Contracts, data: unknown): Completion[] {
  const schema = contracts.schema
  const key = (label: string, info: string, detail = ''): Completion => ({ label, detail, info: info || undefined, apply: `${label}: `, type: 'property' })
  const last = path.at(-1)
  if (path.length === 0) {
    const top = valueAt(schema, ['properties'])
    return Object.entries(isMap(top) ? top : {}).filter(([name]) => !siblings.has(name)).map(([name, part]) => key(name, textOf(resolve(schema, part))))
  }
  const own = Object.fromEntries(siblings)
  if (typeof last === 'number' && stepList(path.at(-2))) {
    const kind = kindOf(own)
    const names = kind === null ? STEP_KINDS.map((one) => one as string) : Object.keys(propertiesOf(schema, kind))
    const general = kind === null ? ['id', 'name', 'when'] : []
    return [...names, ...general].filter((name) => !siblings.has(name)).map((name) => key(name, keyText(schema, kind ?? name, name) || keyText(schema, 'do', name)))
  }
  if (last === 'with') {
    const found = actionOf(contracts, data, valueAt(data, [...path.slice(0, -1), 'do']))
    const params = found?.action.params['properties']
    return Object.entries(isMap(params) ? params : {}).filter(([name]) => !siblings.has(name)).map(([name, part]) => key(name, isMap(part) ? rangeText(part) : '', unitOf(part)))
  }
  if (last === 'retry') return ['attempts', 'wait', 'factor', 'max_wait', 'jitter', 'on'].filter((name) => !siblings.has(name)).map((name) => key(name, textOf(valueAt(schema, ['$defs', 'key-retry', 'properties', name]))))
  if (path.length === 2 && path[0] === 'params') {
    const param = propertiesIn(resolve(schema, { $ref: '#/$defs/param' }))
    return Object.entries(param).filter(([name]) => !siblings.has(name)).map(([name, part]) => key(name, textOf(part)))
  }
  return []
}

function valuesFor({ path, key }: Context, contracts: Contracts, data: unknown): Completion[] {
  const value = (label: string, detail = '', apply = label): Completion => ({ label, detail, apply, type: 'value' })
  if (key === 'do') return actionsFor(contracts, data)
  if (path.length === 1 && path[0] === 'devices') return [...new Set(contracts.devices.map((one) => one.contract))].map((one) => value(one))
  if (key === 'type' && path[0] === 'params') return ['quantity', 'number', 'integer', 'string', 'boolean', 'array'].map((one) => value(one))
  if (path.at(-1) === 'with') {
    const found = actionOf(contracts, data, valueAt(data, [...path.slice(0, -1), 'do']))
    const part = valueAt(found?.action.params, ['properties', key ?? ''])
    const choices = isMap(part) && Array.isArray(part['enum']) ? part['enum'].map(String) : isMap(part) && part['type'] === 'boolean' ? ['true', 'false'] : []
    const names = namesIn(data).filter(({ name }) => name.startsWith('params.')).map(({ name, detail }) => value(`\${{ ${name} }}`, detail, `"\${{ ${name} }}"`))
    return [...choices.map((one) => value(one)), ...names]
  }
  const part = valueAt(contracts.schema, ['$defs', `key-${key ?? ''}`])
  const choices = isMap(part) && Array.isArray(part['enum']) ? part['enum'] : key === 'mode' ? ['background'] : key === 'on_failure' ? ['finish', 'cancel'] : []
  const words = isMap(part) && Array.isArray(part['enumDescriptions']) ? part['enumDescriptions'] : []
  return choices.map((one, i) => value(String(one), String(words[i] ?? '')))
}

function actionsFor(contracts: Contracts, data: unknown): Completion[] {
  const roles = valueAt(data, ['devices'])
  return Object.entries(isMap(roles) ? roles : {}).flatMap(([role, contract]) => {
    const device = typeof contract === 'string' ? contracts.deviceOf(contract, role) : null
    return (device?.actions ?? []).map((action): Completion => ({ label: `${role}.${action.name}`, info: action.summary, detail: action.danger ?? '', type: 'function' }))
  })
}

function stepList(part: unknown): boolean {
  return ['steps', 'parallel', 'any', 'then', 'else', 'fallback', 'on_resume', 'finally'].includes(String(part))
}

function propertiesOf(schema: Record<string, unknown>, kind: string): Record<string, unknown> {
  return propertiesIn(valueAt(schema, ['$defs', `step-${kind}`]))
}

function propertiesIn(part: unknown): Record<string, unknown> {
  const found = valueAt(part, ['properties'])
  return isMap(found) ? found : {}
}

function textOf(part: unknown): string {
  return isMap(part) && typeof part['description'] === 'string' ? part['description'] : ''
}

function unitOf(part: unknown): string {
  return isMap(part) && typeof part['unit'] === 'string' ? part['unit'] : ''
}
