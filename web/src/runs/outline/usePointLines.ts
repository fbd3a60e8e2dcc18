// The lines below an opened point: its actions, attempt by attempt, from the journal.
import { shallowReactive } from 'vue'
import { api, read } from '../../api/client'
import { sentenceOf } from '../../api/refused'
import type { Received } from '../../api/types'
import type { PointTable } from '../points'
import type { Status } from '../status'
import { duration } from '../time'
import type { RowWords } from './rowWords'

type ActionTold = Received<'ActionTold'>

export interface PointLines {
  /** Table id → index → how many lines. */
  open: Map<string, Map<number, number>>
  line: (table: PointTable, index: number, line: number) => RowWords | null
  toggle: (table: PointTable, index: number) => Promise<void>
}

export function usePointLines(run: () => string): PointLines {
  const open = shallowReactive(new Map<string, Map<number, number>>())
  const kept = new Map<string, RowWords[]>()

  function put(table: PointTable, index: number, words: RowWords[] | null): void {
    const points = new Map(open.get(table.id))
    if (words) points.set(index, words.length)
    else points.delete(index)
    if (words) kept.set(`${table.id}#${index}`, words)
    open.set(table.id, points)
  }

  async function toggle(table: PointTable, index: number): Promise<void> {
    if (open.get(table.id)?.has(index)) {
      put(table, index, null)
      return
    }
    put(table, index, [said('reading…')])
    const key = table.keys[index]
    if (key == null) {
      put(table, index, [said('has not started')])
      return
    }
    try {
      const query = { loop: table.loop, within: table.within, key }
      const told = await read(api.GET('/api/v1/runs/{id}/point', { params: { path: { id: run() }, query } }))
      const words = told.actions.map(actionWords)
      put(table, index, words.length ? words : [said('no action was sent')])
    } catch (fault) {
      put(table, index, [said(sentenceOf(fault))])
    }
  }

  return { open, toggle, line: (table, index, line) => kept.get(`${table.id}#${index}`)?.[line] ?? null }
}

function said(title: string): RowWords {
  return { status: null, title, more: '', bad: false, danger: '' }
}

const ENDS: Record<string, Status> = {
  SUCCEEDED: 'ok', ABORTED: 'failed', REJECTED: 'failed', CANCELED: 'cancelled', LOST: 'unknown', UNKNOWN: 'unknown',
}

/** One attempt as a row. */
export function actionWords(action: ActionTold): RowWords {
  const id = action.node.split('/').at(-1) ?? ''
  const attempt = action.attempt > 1 ? ` (try ${action.attempt})` : ''
  const error = action.error ? `${String(action.error['name'] ?? '')}: ${String(action.error['message'] ?? '')}` : ''
  const time = action.seconds === null ? '' : duration(action.seconds)
  const status = ENDS[action.state.toUpperCase()] ?? (action.ended_at ? 'unknown' : 'running')
  return {
    status, title: `${id} · ${action.device}.${action.action}${attempt}`, bad: error !== '', danger: '',
    more: [error, time].filter(Boolean).join(' · '),
  }
}
