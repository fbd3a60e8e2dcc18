// Where the caret is in the tree of the text, from indentation: the text may be incomplete.
import type { Text } from '@codemirror/state'

export interface Context {
  /** The map or list that the caret is in; indexes of lists are counted. */
  path: (string | number)[]
  /** The key whose value is being written; null if a key is. */
  key: string | null
  /** What is beside it already, as far as one line shows. */
  siblings: Map<string, string>
}

const PAIR = /^(?:"([^"]*)"|([\w$.-]+))\s*:(?:\s+(.*))?$/
const MOST_LINES = 4_000

interface Line {
  indent: number
  dashes: number
  key: string | null
  value: string
  blank: boolean
}

function lineOf(text: string): Line {
  const indent = /^ */.exec(text)?.[0].length ?? 0
  let rest = text.slice(indent)
  let dashes = 0
  let at = indent
  for (let dash = /^-( +|$)/.exec(rest); dash; dash = /^-( +|$)/.exec(rest)) {
    dashes++
    at += dash[0].length
    rest = rest.slice(dash[0].length)
  }
  const pair = PAIR.exec(rest)
  const blank = rest.trim() === '' && dashes === 0
  return { indent: at, dashes, key: pair ? (pair[1] ?? pair[2] ?? null) : null, value: pair?.[3] ?? '', blank: blank || rest.startsWith('#') }
}

/** The path to the caret. Inside brackets on one line, the pairs before it count as well. */
export function contextAt(doc: Text, at: number): Context {
  const here = doc.lineAt(at)
  const head = here.text.slice(0, at - here.from)
  const line = lineOf(head)
  const inFlow = flowAt(head)
  const column = line.blank ? Math.max(line.indent, head.length) : line.indent
  const outer = above(doc, here.number, line.dashes > 0 ? line.indent - 2 * line.dashes : column, line.dashes)
  const siblings = inFlow ? inFlow.siblings : siblingsOf(doc, here.number, column)
  const dashed = [...outer, ...(line.dashes > 0 ? [indexOf(doc, here.number, line.indent - 2)] : [])]
  if (inFlow) {
    const opened = inFlow.opened ?? line.key
    const base = line.key !== null && inFlow.outer ? [...dashed, line.key] : dashed
    return { path: opened !== null && opened !== line.key ? [...base, opened] : line.key !== null ? [...dashed, line.key] : dashed, key: inFlow.key, siblings }
  }
  return { path: dashed, key: line.key !== null && /:\s/.test(head.slice(line.indent)) ? line.key : null, siblings }
}

/** Keys of the lines above, each further to the left. */
function above(doc: Text, number: number, column: number, dashes: number): (string | number)[] {
  const path: (string | number)[] = []
  let forKeys = dashes > 0 ? column + 1 : column
  let forDashes = column
  for (let n = number - 1; n >= 1 && forKeys > 0 && number - n < MOST_LINES; n--) {
    const line = lineOf(doc.line(n).text)
    if (line.blank) continue
    const dashAt = line.indent - 2 * line.dashes
    if (line.indent < forKeys && line.key !== null) {
      path.unshift(line.key)
      forKeys = forDashes = line.indent
    }
    if (line.dashes > 0 && dashAt < forDashes) {
      path.unshift(indexOf(doc, n, dashAt))
      forKeys = dashAt + 1
      forDashes = dashAt
    }
  }
  return path
}

/** The index in its list of the line with a dash at this column. */
function indexOf(doc: Text, number: number, column: number): number {
  let index = 0
  for (let n = number - 1; n >= 1 && number - n < MOST_LINES; n--) {
    const text = doc.line(n).text
    const indent = /^ */.exec(text)?.[0].length ?? 0
    if (text.trim() === '' || text.trimStart().startsWith('#')) continue
    if (indent < column || (indent === column && !text.startsWith('-', indent))) break
    if (indent === column) index++
  }
  return index
}

function siblingsOf(doc: Text, number: number, column: number): Map<string, string> {
  const found = new Map<string, string>()
  for (const step of [-1, 1]) {
    for (let n = step < 0 ? number : number + 1; n >= 1 && n <= doc.lines && Math.abs(n - number) < 400; n += step) {
      const line = lineOf(doc.line(n).text)
      if (line.blank) continue
      if (line.indent < column || (step > 0 && line.dashes > 0 && line.indent <= column)) break
      if (line.indent === column && line.key !== null && n !== number) found.set(line.key, line.value)
      if (step < 0 && line.indent === column && line.dashes > 0) break
    }
  }
  const own = lineOf(doc.line(number).text)
  if (own.key !== null && own.value !== '') found.set(own.key, own.value)
  return found
}

interface Flow {
  opened: string | null
  outer: boolean
  key: string | null
  siblings: Map<string, string>
}

/** Inside `{...}` on one line: the key of the innermost brace, and the key whose value is being written. */
function flowAt(head: string): Flow | null {
  const stack: Flow[] = []
  let word = ''
  let key: string | null = null
  for (const one of head.replace(/\$\{\{.*?\}\}/g, (all) => '_'.repeat(all.length))) {
    if (one === '{') {
      stack.push({ opened: key, outer: stack.length > 0, key: null, siblings: new Map() })
      word = ''
      key = null
    } else if (one === '}') {
      stack.pop()
      word = ''
      key = null
    } else if (one === ':') {
      key = word.trim().replace(/^- /, '').replaceAll('"', '')
      const top = stack.at(-1)
      if (top) Object.assign(top, { key })
      word = ''
    } else if (one === ',') {
      const top = stack.at(-1)
      if (top?.key != null) top.siblings.set(top.key, word.trim())
      if (top) top.key = null
      word = ''
      key = null
    } else word += one
  }
  return stack.at(-1) ?? null
}
