// The progress strip of a run as text, which screen readers read as well.
import type { RunHead } from './picture'
import { pointsWords } from './pointsWords'
import { FATE_LOOKS, isOver } from './status'
import { clockRange, duration, etaWords, until } from './time'

/** `412 of 1,071`, `3.9/min`, `ends 16:10–16:25`, `2 retries`, `1 skipped` - whichever are known. */
export function stripWords(head: RunHead, now: Date): string[] {
  const parts: string[] = []
  parts.push(...pointsWords(head))
  const goesOn = head.live && !isOver(head.fate)
  if (goesOn && head.per_minute) parts.push(pace(head.per_minute))
  const eta = goesOn ? etaWords(head.eta, now) : ''
  if (eta) parts.push(eta)
  if (head.retries) parts.push(head.retries === 1 ? '1 retry' : `${head.retries} retries`)
  if (head.holes !== head.failed) parts.push(head.holes === 1 ? '1 hole' : `${head.holes} holes`)
  if (head.resumes) parts.push(`resumed ${head.resumes}×`)
  return parts
}

/** A pace that a person can picture: per minute, or how long one takes. */
export function pace(perMinute: number): string {
  return perMinute >= 1 ? `${Number(perMinute.toPrecision(3))}/min` : `${duration(60 / perMinute)} per point`
}

/** `next needs you: 16:10–16:25, change the sample (in 12 min)`. */
export function needsYouWords(head: RunHead, now: Date): string {
  if (!head.live) return ''
  if (head.open_questions.length) return 'needs you now'
  if (!head.needs_you) return ''
  const [low, high] = [new Date(head.needs_you.low), new Date(head.needs_you.high)]
  return `next needs you: ${clockRange(low, high, now)} (${until(low, now)}), ${head.needs_you.text}`
}

/** One sentence for screen readers. */
export function aloud(head: RunHead): string {
  const question = head.open_questions[0]
  if (question) return `The run asks: ${question.text}`
  return [`${head.protocol} ${head.word || FATE_LOOKS[head.fate].word}`, ...pointsWords(head)].join(', ')
}
