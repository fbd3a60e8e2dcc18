// Fixes for problems, derived from the checker's messages.

export interface Fix {
  label: string
  from: number
  to: number
  insert: string
  /** Instead of the insertion: this action, as a step that always ends the protocol. */
  atEnd?: string
}

const SUGGESTED = /['‘’]?([^\s'‘’]+)['‘’]?; did you mean (.+?)\?/
const OUTSIDE = /: (-?[\d.]+)[^:]* is outside (?:[\w.]+ )?(-?[\d.]+)\.\.(-?[\d.]+) ?([^\s,;]*)/
const AT_END = /`finally: \[\{do: ([\w.]+), on_error: continue\}\]`/
const WRITE = /(?:^|: )write (?:`(.+)`|("[^]+"|'[^]+'))$/

/** `text` is what the problem points at; null if there is no certain fix. */
export function fixOf(message: string, hint: string, text: string, from: number): Fix | null {
  return suggested(message, text, from) ?? nearest(message, text, from) ?? written(hint, text, from) ?? lastly(hint, from)
}

function suggested(message: string, text: string, from: number): Fix | null {
  const match = SUGGESTED.exec(message)
  if (!match) return null
  const [, wrong = '', right = ''] = match
  const at = wordAt(text, wrong)
  if (at >= 0) return fix(right.split('.').at(-1) ?? right, from + at, wrong.length)
  const whole = message.split(':')[0] ?? ''
  const place = right.includes('.') && whole !== '' ? text.indexOf(whole) : -1
  return place < 0 ? null : fix(right, from + place, whole.length)
}

/** The bound nearest to a number outside its range. */
function nearest(message: string, text: string, from: number): Fix | null {
  const match = OUTSIDE.exec(message)
  if (!match || text.includes('${{')) return null
  const [, is = '', low = '', high = '', unit = ''] = match
  const bound = Number(is) > Number(high) ? high : low
  return fix(unit === '' || /^-?[\d.]+$/.test(text) ? bound : `${bound} ${unit}`, from, text.length)
}

function written(hint: string, text: string, from: number): Fix | null {
  const match = WRITE.exec(hint)
  const insert = match?.[1] ?? match?.[2] ?? '…'
  const [, quote, begun = ''] = /^(["'])(.+)\.\.\.\1$/.exec(insert) ?? []
  // A long one is cut in the message.
  if (quote && text.startsWith(begun)) return fix(quote + text + quote, from, text.length)
  return /…|\.\.\./.test(insert) ? null : fix(insert, from, text.length)
}

function lastly(hint: string, from: number): Fix | null {
  const action = AT_END.exec(hint)?.[1]
  return action === undefined ? null : { label: `Add ${action} at the end`, from, to: from, insert: '', atEnd: action }
}

function fix(insert: string, from: number, length: number): Fix {
  return { label: `Use ${insert}`, from, to: from + length, insert }
}

/** The position of a whole word; -1 if absent. */
function wordAt(text: string, word: string): number {
  const escaped = word.replace(/[.*+?^${}()|[\]\\]/g, '\\$&')
  const match = new RegExp(`(?<![\\w])${escaped}(?![\\w])`).exec(text)
  return match?.index ?? -1
}
