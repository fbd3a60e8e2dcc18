// What can be said of a step: what the journal tells, and what follows from the steps around it.
import type { Told } from '../../api/types'
import type { RunPicture } from '../picture'
import type { Status } from '../status'

type OutlineNode = Told<'OutlineNode'>

/** Steps of these kinds always leave a record when they run; others (`set`, `if`, groups) need not. */
const LEAVE_RECORDS = new Set(['do', 'confirm', 'ask', 'wait', 'log', 'require', 'fail'])
const NOT_IN_ORDER = new Set(['parallel', 'any', 'if'])

export interface StepSays {
  status: Status | null
  /** Said instead of numbers where there are none. */
  words: string
}

export function stepStatus(step: OutlineNode, run: RunPicture): StepSays {
  const own = run.nodes.get(step.path)?.status
  if (own !== undefined && own !== 'waiting') return { status: own, words: '' }
  if (run.head.live && isInside(step, run)) return { status: 'running', words: '' }
  if (own === 'waiting') return { status: run.head.live ? 'waiting' : null, words: run.head.live ? '' : 'not finished' }
  if (wasPassed(step, run)) return { status: null, words: LEAVE_RECORDS.has(step.kind) ? 'passed over' : '' }
  if (run.head.live) return { status: 'waiting', words: '' }
  return { status: null, words: LEAVE_RECORDS.has(step.kind) ? 'not run' : '' }
}

/** Something within it is under way. */
function isInside(step: OutlineNode, run: RunPicture): boolean {
  const within = `${step.path}/`
  if (run.head.loops.some((loop) => loop.current !== null && (loop.path === step.path || loop.path.startsWith(within)))) return true
  return run.head.under_way.some((one) => one.node.startsWith(within))
}

/** A step after it in the same order has begun already. */
function wasPassed(step: OutlineNode, run: RunPicture): boolean {
  const outline = run.detail.outline
  const parent = outline.find((one) => one.path === step.parent)
  if (parent && (NOT_IN_ORDER.has(parent.kind) || parent.loop)) return false
  const after = outline.slice(outline.findIndex((one) => one.path === step.path) + 1)
  const phase = step.path.split('/')[0]
  return after.some((one) => {
    if (one.parent !== step.parent || one.path.split('/')[0] !== phase) return false
    const state = run.nodes.get(one.path)
    return (state !== undefined && state.status !== 'waiting') || isInside(one, run)
  })
}
