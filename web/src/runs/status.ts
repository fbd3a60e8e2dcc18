// A status is shown by icon, word and colour together, never by colour alone.

export type Status =
  | 'waiting' | 'running' | 'ok' | 'retrying' | 'skipped' | 'failed' | 'cancelled' | 'unknown'
export type Fate =
  | 'starting' | 'running' | 'paused' | 'succeeded' | 'failed' | 'aborted' | 'interrupted' | 'unreadable'

/** `tone` is the name of a colour of the page; the style sheet defines it for light and dark. */
export interface Look {
  icon: string
  word: string
  tone: 'muted' | 'accent' | 'ok' | 'warn' | 'fail' | 'paused'
}

export const STATUSES: readonly Status[] = [
  'waiting', 'running', 'ok', 'retrying', 'skipped', 'failed', 'cancelled', 'unknown',
]

export const STATUS_LOOKS: Record<Status, Look> = {
  waiting: { icon: '·', word: 'waiting', tone: 'muted' },
  running: { icon: '▶', word: 'running', tone: 'accent' },
  ok: { icon: '✓', word: 'ok', tone: 'ok' },
  retrying: { icon: '↻', word: 'retrying', tone: 'warn' },
  skipped: { icon: '⤼', word: 'skipped', tone: 'muted' },
  failed: { icon: '✕', word: 'failed', tone: 'fail' },
  cancelled: { icon: '■', word: 'unfinished', tone: 'warn' },
  unknown: { icon: '?', word: 'unknown', tone: 'warn' },
}

export const FATE_LOOKS: Record<Fate, Look> = {
  starting: { icon: '…', word: 'starting', tone: 'accent' },
  running: { icon: '▶', word: 'running', tone: 'accent' },
  paused: { icon: '‖', word: 'paused', tone: 'paused' },
  succeeded: { icon: '✓', word: 'succeeded', tone: 'ok' },
  failed: { icon: '✕', word: 'failed', tone: 'fail' },
  aborted: { icon: '■', word: 'aborted', tone: 'warn' },
  interrupted: { icon: '⚡', word: 'interrupted', tone: 'warn' },
  unreadable: { icon: '?', word: 'unreadable', tone: 'fail' },
}

/** What a person looks for under "only problems". */
export function isProblem(status: Status): boolean {
  return status === 'failed' || status === 'unknown' || status === 'retrying' || status === 'cancelled'
}

/** Nothing is sent to a device any more, though the engine may still write its report. */
export function isOver(fate: Fate): boolean {
  return fate === 'succeeded' || fate === 'failed' || fate === 'aborted'
}

/** A run that a new engine can resume. */
export function canResume(fate: Fate): boolean {
  return fate === 'failed' || fate === 'aborted' || fate === 'interrupted'
}

/** What a run did, and why: one that was aborted says it in its reason. */
export function endWords(fate: Fate, reason: string): string {
  return reason.startsWith(`${fate} `) ? reason : [fate, reason].filter(Boolean).join(': ')
}
