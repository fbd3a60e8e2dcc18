// An expression that is one call, taken apart: its arguments stay as they are written.

export interface Call {
  name: string
  args: readonly Argument[]
}

export interface Argument {
  /** Empty for a positional one. */
  key: string
  text: string
}

/** `span(0, 4 mm, 1 mm)` of `${{ span(0, 4 mm, 1 mm) }}`; null if the text is not one expression. */
export function innerOf(value: unknown): string | null {
  if (typeof value !== 'string') return null
  const inner = /^\s*\$\{\{(.*)\}\}\s*$/s.exec(value)?.[1]
  return inner === undefined || inner.includes('${{') ? null : inner.trim()
}

/** Null if it is anything but one call. */
export function callOf(text: string): Call | null {
  const match = /^\s*([a-z_]\w*)\s*\((.*)\)\s*$/is.exec(text)
  const parts = match?.[2] === undefined ? null : partsOf(match[2])
  if (!match || parts === null) return null
  const args = parts.map((part): Argument => {
    const named = /^\s*([a-z_]\w*)\s*=(?!=)(.*)$/is.exec(part)
    return named ? { key: named[1] ?? '', text: (named[2] ?? '').trim() } : { key: '', text: part.trim() }
  })
  return { name: match[1] ?? '', args }
}

/** The items of `[20 mm, 30 mm]`. */
export function itemsOf(text: string): readonly string[] | null {
  const inner = /^\s*\[(.*)\]\s*$/s.exec(text)?.[1]
  return inner === undefined ? null : (partsOf(inner)?.map((one) => one.trim()) ?? null)
}

const CLOSES: Record<string, string> = { '(': ')', '[': ']', '{': '}' }

/** Split at the commas that are in no bracket and no text; null if a bracket is closed that was not opened. */
function partsOf(text: string): string[] | null {
  const parts: string[] = []
  const open: string[] = []
  let [from, quote] = [0, '']
  for (let at = 0; at < text.length; at++) {
    const sign = text.charAt(at)
    if (quote !== '') {
      if (sign === '\\') at++
      else if (sign === quote) quote = ''
    } else if (sign === '"' || sign === "'") quote = sign
    else if (CLOSES[sign] !== undefined) open.push(CLOSES[sign])
    else if (sign === ')' || sign === ']' || sign === '}') {
      if (open.pop() !== sign) return null
    } else if (sign === ',' && open.length === 0) {
      parts.push(text.slice(from, at))
      from = at + 1
    }
  }
  if (open.length > 0 || quote !== '') return null
  const last = text.slice(from)
  if (last.trim() !== '' || parts.length > 0) parts.push(last)
  return parts
}

/** The text between quotes; null if it is not a plain one. */
export function unquoted(text: string): string | null {
  return /^'([^'\\]*)'$|^"([^"\\]*)"$/.exec(text)?.slice(1).find((one) => one !== undefined) ?? null
}

const FACTOR: Record<string, number> = { '': 1, um: 0.001, 'µm': 0.001, mm: 1, cm: 10, m: 1000 }

/** A length as written, in mm; a bare number counts as mm. */
export function millimetres(text: unknown): number | null {
  if (typeof text === 'number') return text
  const match = typeof text === 'string' ? /^\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*(\S*)\s*$/i.exec(text) : null
  const factor = FACTOR[match?.[2] ?? '?']
  return match && factor !== undefined ? Number(match[1]) * factor : null
}

/** Micrometres are as fine as any stage is. */
export function rounded(mm: number): number {
  return Math.round(mm * 1e6) / 1e6
}
