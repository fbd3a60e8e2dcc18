// The outline as rows that are created on demand: 100,000 points are one segment.
import type { PointTable } from '../points'

/** A step of the protocol, as the server sends it. */
export interface StepNode {
  path: string
  parent: string | null
  depth: number
  loop: boolean
  title: string
}

/** `lines` are rows below an opened point: its actions, attempt by attempt. */
export type Row =
  | { kind: 'step'; id: string; depth: number; step: StepNode; open: boolean | null }
  | { kind: 'points'; id: string; depth: number; table: PointTable; open: boolean }
  | { kind: 'point'; id: string; depth: number; table: PointTable; index: number; open: boolean }
  | { kind: 'detail'; id: string; depth: number; table: PointTable; index: number; line: number }

/** What is open in the outline, and the search text. */
export interface View {
  closed: ReadonlySet<string>
  /** Ids of tables whose points are shown. */
  openTables: ReadonlySet<string>
  /** Table id → index → how many lines are below that point. */
  openPoints: ReadonlyMap<string, ReadonlyMap<number, number>>
  onlyProblems: boolean
  find: string
  /** Where a step has a problem. */
  isProblem: (path: string) => boolean
}

interface Segment {
  first: number
  size: number
  at: (offset: number) => Row
}

export class Rows {
  readonly size: number
  private readonly segments: Segment[] = []

  constructor(steps: readonly StepNode[], tables: ReadonlyMap<string, readonly PointTable[]>, private readonly view: View) {
    const parents = new Set(steps.map((step) => step.parent))
    let end = 0
    const add = (size: number, at: (offset: number) => Row): void => {
      if (size > 0) this.segments.push({ first: end, size, at })
      end += size
    }
    this.walk(steps, (step) => {
      if (this.fits(step)) {
        const open = parents.has(step.path) ? !view.closed.has(step.path) : null
        add(1, () => ({ kind: 'step', id: step.path, depth: step.depth, step, open }))
      }
    }, (loop) => {
      for (const table of tables.get(loop.path) ?? []) this.points(loop.depth + 1, table, add)
    })
    this.size = end
  }

  /** The row at an index; created each time. */
  at(index: number): Row | undefined {
    let [low, high] = [0, this.segments.length - 1]
    while (low <= high) {
      const middle = (low + high) >> 1
      const segment = this.segments[middle]
      if (!segment) return undefined
      if (index < segment.first) high = middle - 1
      else if (index >= segment.first + segment.size) low = middle + 1
      else return segment.at(index - segment.first)
    }
    return undefined
  }

  /** The index of a row with this id; checks one row of each segment, and points by their index. */
  indexOf(id: string): number {
    for (const segment of this.segments) {
      if (segment.size === 1 && segment.at(0).id === id) return segment.first
      for (let i = 0; segment.size > 1 && i < segment.size; i++) if (segment.at(i).id === id) return segment.first + i
    }
    return -1
  }

  /** The rows of a window. */
  window(first: number, count: number): { index: number; row: Row }[] {
    const found: { index: number; row: Row }[] = []
    for (let index = Math.max(0, first); index < Math.min(this.size, first + count); index++) {
      const row = this.at(index)
      if (row) found.push({ index, row })
    }
    return found
  }

  private walk(
    steps: readonly StepNode[], step: (one: StepNode) => void, after: (loop: StepNode) => void,
  ): void {
    const loops: StepNode[] = []
    let hiddenBelow = Infinity
    for (const one of steps) {
      leave(loops, one.depth, after)
      if (one.depth > hiddenBelow) continue
      hiddenBelow = this.view.closed.has(one.path) ? one.depth : Infinity
      step(one)
      if (one.loop && hiddenBelow === Infinity) loops.push(one)
    }
    leave(loops, 0, after)
  }

  private fits(step: StepNode): boolean {
    const { find, onlyProblems, isProblem } = this.view
    if (onlyProblems && !isProblem(step.path)) return false
    return !find || step.title.toLowerCase().includes(find) || step.path.toLowerCase().includes(find)
  }

  private points(depth: number, table: PointTable, add: (size: number, at: (offset: number) => Row) => void): void {
    const chosen = chosenPoints(table, this.view)
    const size = chosen ? chosen.length : table.size
    if (!size) return
    const isOpen = this.view.openTables.has(table.id) || this.view.onlyProblems || this.view.find !== ''
    add(1, () => ({ kind: 'points', id: `${table.id}/*`, depth, table, open: isOpen }))
    if (!isOpen) return
    const opened = this.view.openPoints.get(table.id)
    const point = (i: number): Row => {
      const index = chosen ? (chosen[i] ?? 0) : i
      const id = `${table.id}#${index}`
      return { kind: 'point', id, depth: depth + 1, table, index, open: opened?.has(index) ?? false }
    }
    let from = 0
    for (const [index, lines] of [...(opened ?? [])].sort((a, b) => a[0] - b[0])) {
      const i = chosen ? chosen.indexOf(index) : index
      if (i < 0 || i >= size) continue
      const start = from
      add(i + 1 - start, (offset) => point(start + offset))
      add(lines, (line) => ({
        kind: 'detail', id: `${table.id}#${index}.${line}`, depth: depth + 2, table, index, line,
      }))
      from = i + 1
    }
    const rest = from
    add(size - rest, (offset) => point(rest + offset))
  }
}

/** Loops that end where a step of this depth begins, the innermost first. */
function leave(loops: StepNode[], depth: number, after: (loop: StepNode) => void): void {
  for (let loop = loops.at(-1); loop && depth <= loop.depth; loop = loops.at(-1)) {
    loops.pop()
    after(loop)
  }
}

/** The points that match the search; null: all of them. */
function chosenPoints(table: PointTable, { onlyProblems, find }: View): number[] | null {
  if (!onlyProblems && !find) return null
  const from = onlyProblems ? table.problems() : Array.from({ length: table.size }, (_, i) => i)
  if (!find) return from
  return from.filter((i) => (table.keys[i] ?? '').includes(find) || table.message(i).toLowerCase().includes(find))
}
