// The bench as the server sends it: a snapshot, then numbered patches; after a gap, a new snapshot is requested.
import type {
  ControlState, DeviceState, GoalState, JogState, LaunchState, Patch, RunSummary, Snapshot,
} from '../types'

export interface Bench {
  seq: number
  bench: string
  devices: Record<string, DeviceState>
  runs: Record<string, RunSummary>
  goals: Record<string, GoalState>
  jogs: Record<string, JogState>
  launches: Record<string, LaunchState>
  control: ControlState
}

const NOBODY: ControlState = { holder: null, since: null, ends_at: null, armed: false }

export function emptyBench(): Bench {
  return {
    seq: -1, bench: '', devices: {}, runs: {}, goals: {}, jogs: {}, launches: {}, control: NOBODY,
  }
}

/** The whole bench, from a snapshot. */
export function fromSnapshot(told: Snapshot): Bench {
  const { seq, bench, devices, runs, goals, jogs, launches, control } = told
  return { seq, bench, devices, runs, goals, jogs, launches, control }
}

/** Apply a patch; false, with nothing changed, if one before it is missing. */
export function applyPatch(bench: Bench, patch: Patch): boolean {
  if (patch.seq <= bench.seq) return true // older than the snapshot
  if (patch.seq !== bench.seq + 1) return false
  bench.seq = patch.seq
  merge(bench.devices, patch.devices)
  merge(bench.runs, patch.runs)
  merge(bench.goals, patch.goals)
  merge(bench.jogs, patch.jogs)
  merge(bench.launches, patch.launches)
  if (patch.control !== null) bench.control = patch.control
  return true
}

function merge<T>(into: Record<string, T>, changed: Readonly<Record<string, T | null>>): void {
  for (const [name, value] of Object.entries(changed)) {
    if (value === null) Reflect.deleteProperty(into, name)
    else into[name] = value
  }
}
