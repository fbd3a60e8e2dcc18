// A text read once: its values, its places and its comments, or its first YAML error.
import { Lexer, parseDocument } from 'yaml'
import { placesOf, type Place } from './place'

export interface Read {
  ok: true
  text: string
  data: unknown
  root: Place | null
  /** Written as JSON: insertions are written as JSON, too. */
  json: boolean
}

export interface Broken {
  ok: false
  text: string
  message: string
  offset: number
  line: number
}

export type Reading = Read | Broken

const SCALAR = '\u001f'
const MARKS = new Set(['\u0002', '\u0018', SCALAR])
const MOST_ALIASES = 200

let last: Reading | null = null

/** The last text read is cached: a checked patch is not read again when it is applied. */
export function read(text: string): Reading {
  if (last?.text !== text) last = readAnew(text)
  return last
}

function readAnew(text: string): Reading {
  const doc = parseDocument(text, {
    keepSourceTokens: true, prettyErrors: false, merge: true, stringKeys: true, logLevel: 'silent',
  })
  const fault = doc.errors[0]
  if (fault) return broken(text, fault.message, fault.pos[0])
  try {
    const data: unknown = doc.toJS({ maxAliasCount: MOST_ALIASES })
    return { ok: true, text, data, root: placesOf(doc, text), json: /^\s*\{\s*("|\})/.test(text) }
  } catch (error) {
    return broken(text, error instanceof Error ? error.message : String(error), 0)
  }
}

function broken(text: string, message: string, offset: number): Broken {
  return { ok: false, text, message, offset, line: text.slice(0, offset).split('\n').length }
}

export interface Comment {
  from: number
  text: string
}

/** Every comment with its `#`, in order; what looks like one inside a value does not count. */
export function commentsOf(text: string): Comment[] {
  const found: Comment[] = []
  let at = 0
  let inScalar = false
  for (const lexeme of new Lexer().lex(text)) {
    if (MARKS.has(lexeme)) {
      inScalar = lexeme === SCALAR
      continue
    }
    if (!inScalar && lexeme.startsWith('#')) found.push({ from: at, text: lexeme.trimEnd() })
    inScalar = false
    at += lexeme.length
  }
  return found
}
