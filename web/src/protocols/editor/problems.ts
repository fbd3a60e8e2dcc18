// Problems as the editor shows them: each at its position in the text, kept there while the user types.
import type { Problem } from '../../api/types'
import type { Broken } from '../text/reading'
import { counted } from '../../ui/format'
import { fixOf, type Fix } from './fixes'

export interface Found {
  from: number
  to: number
  line: number
  severity: 'error' | 'warning'
  code: string
  message: string
  hint: string
  pointer: string | null
  /** The other file, if the problem is not in this one. */
  file: string | null
  fix: Fix | null
}

/** The checker's problems in a text; those in other files are at its beginning. */
export function foundIn(text: string, problems: readonly Problem[], name: string): Found[] {
  const starts = [0]
  for (let at = text.indexOf('\n'); at >= 0; at = text.indexOf('\n', at + 1)) starts.push(at + 1)
  return problems.map((problem) => {
    const here = problem.file === name || problem.file.endsWith(`/${name}`)
    const from = here ? Math.min((starts[problem.line - 1] ?? text.length) + problem.column - 1, text.length) : 0
    const to = here ? Math.min(from + Math.max(problem.length, 1), text.length) : 0
    const { severity, code, message, hint, pointer } = problem
    const fix = here ? fixOf(message, hint, text.slice(from, to), from) : null
    return { from, to, line: here ? problem.line : 1, severity, code, message, hint, pointer, file: here ? null : problem.file, fix }
  })
}

/** What the page detects itself, at once: the text is not YAML. */
export function brokenAt(broken: Broken): Found {
  const from = Math.min(broken.offset, broken.text.length)
  return {
    from, to: Math.min(from + 1, broken.text.length), line: broken.line, severity: 'error', code: 'YAML',
    message: upper(broken.message), hint: '', pointer: null, file: null, fix: null,
  }
}

function upper(text: string): string {
  return text.charAt(0).toUpperCase() + text.slice(1)
}

export interface Mapping {
  mapPos(at: number, bias?: number): number
}

/** The same problems after the text has changed. */
export function moved(all: readonly Found[], by: Mapping, lineOf: (at: number) => number): Found[] {
  return all.map((one) => {
    const from = by.mapPos(one.from, 1)
    const fix = one.fix && { ...one.fix, from: by.mapPos(one.fix.from, 1), to: by.mapPos(one.fix.to, -1) }
    return { ...one, from, to: Math.max(from, by.mapPos(one.to, -1)), line: lineOf(from), fix }
  })
}

/** `2 errors, 1 warning`. */
export function countOf(all: readonly Found[]): string {
  const errors = all.filter((one) => one.severity === 'error').length
  const warnings = all.length - errors
  const words = [errors > 0 ? counted(errors, 'error') : '', warnings > 0 ? counted(warnings, 'warning') : '']
  return words.filter(Boolean).join(', ') || 'no problems'
}
