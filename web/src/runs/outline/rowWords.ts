// The text of a row of the outline.
import type { NodeState, RunPicture } from '../picture'
import type { PointTable } from '../points'
import type { Status } from '../status'
import { duration } from '../time'
import { counted } from '../../ui/format'
import type { Row } from './rows'
import { stepStatus } from './stepStatus'
import type { PointLines } from './usePointLines'

export interface RowWords {
  status: Status | null
  title: string
  more: string
  bad: boolean
  danger: string
}

export function rowWords(
  row: Row, run: RunPicture, lines: PointLines, name: (table: PointTable, index: number) => string,
): RowWords {
  if (row.kind === 'step') {
    const state = run.nodes.get(row.id)
    const step = run.detail.outline.find((one) => one.path === row.id)
    const danger = step?.danger && step.danger !== 'motion' ? step.danger : ''
    const [more, bad] = state ? stateWords(state) : ['', false]
    // What a finished run never reached is no longer waiting.
    const { status, words } = step ? stepStatus(step, run) : { status: null, words: '' }
    return { status, title: row.step.title, more: more || words, bad, danger }
  }
  if (row.kind === 'points') {
    const loop = run.head.loops.find((one) => one.path === row.table.loop)
    const within = row.table.within ? `${row.table.within}: ` : ''
    const bad = (loop?.failed ?? 0) > 0 && !row.table.within
    const more = loop && !row.table.within ? counts([[loop.succeeded, '✓'], [loop.failed, '✕'], [loop.skipped, '⤼']]) : ''
    return { status: null, title: `${within}${counted(row.table.size, 'point')}`, more, bad, danger: '' }
  }
  if (row.kind === 'point') {
    const { table, index } = row
    const seconds = table.seconds[index]
    const tries = table.tries(index)
    const message = table.message(index)
    const more = [message, tries ? `${tries} sent again` : '', seconds === undefined || Number.isNaN(seconds) ? '' : duration(seconds)]
    return { status: table.status(index), title: name(table, index), more: more.filter(Boolean).join(' · '), bad: message !== '', danger: '' }
  }
  const line = lines.line(row.table, row.index, row.line)
  return line ?? { status: null, title: '…', more: '', bad: false, danger: '' }
}

/** The counts of a step over all points of its loops. */
export function stateWords(state: NodeState): [words: string, bad: boolean] {
  const bad = state.failed > 0 || state.unknown > 0
  const several = state.ok + state.failed + state.skipped + state.unknown > 1
  const numbers: [number, string][] = [[several ? state.ok : 0, '✓'], [state.failed, '✕'], [state.skipped, '⤼'], [state.unknown, '?'], [state.retries, '↻']]
  const time = state.last_s === null ? '' : duration(state.last_s)
  return [[bad ? state.message : '', counts(numbers), time].filter(Boolean).join(' · '), bad]
}

function counts(numbers: readonly (readonly [number, string])[]): string {
  return numbers.filter(([n]) => n > 0).map(([n, icon]) => `${n.toLocaleString('en')} ${icon}`).join(' ')
}
