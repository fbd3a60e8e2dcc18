// A run as this page knows it: the first full state and every patch since, without a gap.
import type { Received, RunDetail, RunPatch } from '../api/types'
import { PointTable, type PointWindow } from './points'
import { isProblem } from './status'

export type RunHead = Received<'RunHead'>
export type NodeState = Received<'NodeState'>

/** What a patch has changed, so that only that is redrawn. */
export interface Change {
  /** Table id → indexes of its points. */
  points: Map<string, number[]>
  /** True if a table was added. */
  newTable: boolean
}

export class RunPicture {
  head: RunHead
  readonly nodes: Map<string, NodeState>
  /** Loop → its tables: one, or one for each iteration of the loops around it. */
  readonly tables = new Map<string, PointTable[]>()
  private seq: number

  constructor(readonly detail: RunDetail) {
    this.head = detail
    this.seq = detail.seq
    this.nodes = new Map(Object.entries(detail.nodes))
    for (const loop of detail.loops) this.tables.set(loop.path, [])
  }

  /** Apply a patch; null if one before it is missing and the whole must be requested again. */
  take(patch: RunPatch): Change | null {
    if (patch.seq <= this.seq) return { points: new Map(), newTable: false }
    if (patch.seq !== this.seq + 1) return null
    this.seq = patch.seq
    this.head = patch.head
    for (const [path, state] of Object.entries(patch.nodes)) this.nodes.set(path, state)
    const change: Change = { points: new Map(), newTable: false }
    for (const point of patch.points) {
      const known = this.known(point.loop, point.within)
      if (!known) change.newTable = true
      const table = known ?? this.table(point.loop, point.within)
      const changed = change.points.get(table.id) ?? []
      changed.push(table.set(point))
      change.points.set(table.id, changed)
    }
    return change
  }

  /** The points of a loop; `within` are the keys of the loops around it. */
  table(loop: string, within = ''): PointTable {
    const known = this.known(loop, within)
    if (known) return known
    const made = new PointTable(loop, within)
    this.tables.set(loop, [...(this.tables.get(loop) ?? []), made])
    return made
  }

  load(loop: string, within: string, window: PointWindow): void {
    this.table(loop, within).load(window)
  }

  /** All tables with points, those with positions on the plane first. */
  filled(): PointTable[] {
    const placed = new Set(this.head.loops.filter((loop) => loop.placed).map((loop) => loop.path))
    const all = [...this.tables.values()].flat().filter((table) => table.size > 0)
    return all.sort((a, b) => Number(placed.has(b.loop)) - Number(placed.has(a.loop)))
  }

  isProblem(path: string): boolean {
    const state = this.nodes.get(path)
    if (!state) return false
    return isProblem(state.status) || state.failed > 0 || state.unknown > 0 || state.retries > 0
  }

  private known(loop: string, within: string): PointTable | undefined {
    return this.tables.get(loop)?.find((table) => table.within === within)
  }
}
