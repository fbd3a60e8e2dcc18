// What can be said of a step: what the journal tells, and what follows from the steps around it.
import type { Told } from '../../api/types'
import type { RunPicture } from '../picture'
import type { Status } from '../status'

type OutlineNode = Told<'OutlineNode'>

/** Steps of these kinds always leave a record when they run; others (`set`, `if`, groups) need not. */
const LEAVE_RECORDS = new Set(['do', 'confirm', 'ask', 'wait', 'log', 'require', 'fail'])

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
  if (run.head.live) return { status: 'waiting', words: '' }
  return { status: null, words: LEAVE_RECORDS.has(step.kind) ? 'not run' : '' }
}

/** Something within it is under way. */
function isInside(step: OutlineNode, run: RunPicture): boolean {
  const within = `${step.path}/`
  if (run.head.loops.some((loop) => loop.current !== null && (loop.path === step.path || loop.path.startsWith(within)))) return true
  return run.head.under_way.some((one) => one.node.startsWith(within))
}
