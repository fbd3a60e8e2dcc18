// How far a run is, in the same four numbers everywhere: plan, measured, failed, left.
export interface FourNumbers {
  total: number | null
  measured: number
  failed: number
  left: number | null
}

const whole = (count: number): string => count.toLocaleString('en')

/** `7 of 35 measured`, `2 failed`, `26 left`; nothing for a run without loops. */
export function pointsWords(run: FourNumbers): string[] {
  if (!run.total && !run.measured && !run.failed) return []
  const of = run.total === null ? '' : ` of ${whole(run.total)}`
  return [
    `${whole(run.measured)}${of} measured`,
    ...(run.failed ? [`${whole(run.failed)} failed`] : []),
    ...(run.left ? [`${whole(run.left)} left`] : []),
  ]
}
