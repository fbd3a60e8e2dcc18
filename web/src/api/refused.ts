// What came instead of an answer: a refusal of the server, or silence.
import type { Fault } from './types'

/** The server said no, and why; or nobody answered (`status` 0). */
export class Refused extends Error {
  constructor(
    readonly status: number,
    readonly fault: Fault,
  ) {
    super(fault.message)
  }

  /** The sentence with what to do now. */
  get sentence(): string {
    return this.fault.hint ? `${this.fault.message}. ${this.fault.hint}` : this.fault.message
  }
}

/** A refusal that the page makes itself, in the server's words. */
export function noAnswer(code: string, message: string, hint = ''): Refused {
  return new Refused(0, { code, message, hint, problems: [], details: {} })
}

/** Any failure as a sentence for a person. */
export function sentenceOf(failure: unknown): string {
  if (failure instanceof Refused) return failure.sentence
  return failure instanceof Error ? failure.message : String(failure)
}
