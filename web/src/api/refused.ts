// What came instead of an answer: a refusal from the server, or silence.
import type { Fault } from './types'

/** The server refused, with a reason; or nothing answered (`status` 0). */
export class Refused extends Error {
  constructor(
    readonly status: number,
    readonly fault: Fault,
  ) {
    super(fault.message)
  }

  /** The message with its hint. */
  get sentence(): string {
    return [this.fault.message, this.fault.hint].filter(Boolean).map(begun).join('. ')
  }
}

/** With a capital, unless it begins with a name such as `scan.yaml` or `2026-11-23_scan`. */
function begun(text: string): string {
  return /^[a-z]+([ ,;]|$)/.test(text) ? text.charAt(0).toUpperCase() + text.slice(1) : text
}

/** A refusal made by the page itself, in the server's format. */
export function noAnswer(code: string, message: string, hint = ''): Refused {
  return new Refused(0, { code, message, hint, problems: [], details: {} })
}

/** Any failure as a sentence for a person. */
export function sentenceOf(failure: unknown): string {
  if (failure instanceof Refused) return failure.sentence
  return failure instanceof Error ? failure.message : String(failure)
}
