// Lists as people write them: one entry per line, no duplicates, no empty lines.
import { typedNumber } from '../ui/format'

/** The lines of a text. */
export function linesOf(text: string): string[] {
  return [...new Set(text.split('\n').map((line) => line.trim()).filter((line) => line !== ''))]
}

/** Step sizes as they are typed: `0.1 1 10` or `0,1; 1; 10`; null if one is not a size. */
export function sizesOf(text: string): number[] | null {
  const parts = text.split(/[\s;]+/).filter((part) => part !== '')
  const sizes = parts.map((part) => typedNumber(part.replace(/,$/, '')) ?? 0)
  const fine = sizes.length > 0 && sizes.length <= 8 && sizes.every((size) => size > 0 && size <= 100)
  return fine ? [...new Set(sizes)].sort((a, b) => a - b) : null
}
