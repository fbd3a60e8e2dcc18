// The status of a step: from the journal, and from the steps around it.
import type { Received } from '../../api/types'
import type { RunPicture } from '../picture'
import { isOver, type Status } from '../status'

type OutlineNode = Received<'OutlineNode'>

/** Steps of these kinds always leave a record when they run; others (`set`, `if`, groups) need not. */
const LEAVE_RECORDS = new Set(['do', 'confirm', 'ask', 'wait', 'log', 'require', 'fail'])

export interface StepSays {
  status: Status | null
  /** Shown instead of numbers if there are none. */
  words: string
}

export function stepStatus(step: OutlineNode, run: RunPicture): StepSays {
  const own = run.nodes.get(step.path)?.status
  if (own !== undefined && own !== 'waiting') return { status: own, words: '' }
  const goesOn = run.head.live && !isOver(run.head.fate) // its report may still be written
  if (goesOn && isInside(step, run)) return { status: 'running', words: '' }
  // A loop within a loop leaves no record of its end.
  if (own === 'waiting' && run.head.fate === 'succeeded') return { status: 'ok', words: '' }
  if (own === 'waiting') return { status: goesOn ? 'waiting' : null, words: goesOn ? '' : 'not finished' }
  if (goesOn) return { status: 'waiting', words: '' }
  return { status: null, words: LEAVE_RECORDS.has(step.kind) ? 'not run' : '' }
}

/** Something within it is under way. */
function isInside(step: OutlineNode, run: RunPicture): boolean {
  const within = `${step.path}/`
  if (run.head.loops.some((loop) => loop.current !== null && (loop.path === step.path || loop.path.startsWith(within)))) return true
  return run.head.under_way.some((one) => one.node.startsWith(within))
}
