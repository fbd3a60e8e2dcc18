// The iterations of one loop as columns, so that 100,000 of them cost little and one can be changed quickly.
import { STATUSES, isProblem, type Status } from './status'

/** A window of iterations, as the server sends it. */
export interface PointWindow {
  total: number | null
  index: readonly number[]
  key: readonly (string | null)[]
  status: readonly Status[]
  x_mm: readonly (number | null)[]
  y_mm: readonly (number | null)[]
  seconds: readonly (number | null)[]
  tries: readonly number[]
  message: readonly string[]
}

/** One iteration, as a patch contains it. */
export interface PointChange {
  index: number
  key: string
  status: Status
  seconds?: number | null
  tries?: number
  message?: string
}

const CODES = new Map(STATUSES.map((status, code) => [status, code]))

export class PointTable {
  /** How many there are; grows if it is not known in advance. */
  size = 0
  keys: (string | null)[] = []
  x = new Float64Array(0)
  y = new Float64Array(0)
  seconds = new Float32Array(0)
  private codes = new Uint8Array(0)
  private readonly counts = new Uint32Array(STATUSES.length)
  private tried = new Uint16Array(0)
  private readonly messages = new Map<number, string>()
  private readonly places = new Map<string, number>()

  /** Its name among all tables of a run. */
  readonly id: string

  constructor(readonly loop: string, readonly within = '') {
    this.id = within ? `${loop}|${within}` : loop
  }

  status(index: number): Status {
    return STATUSES[this.codes[index] ?? 0] ?? 'waiting'
  }

  /** How many have this status now. */
  count(status: Status): number {
    return this.counts[CODES.get(status) ?? 0] ?? 0
  }

  tries(index: number): number {
    return this.tried[index] ?? 0
  }

  message(index: number): string {
    return this.messages.get(index) ?? ''
  }

  indexOf(key: string): number | undefined {
    return this.places.get(key)
  }

  /** Apply a requested window. */
  load(window: PointWindow): void {
    const last = window.index.at(-1) ?? -1
    this.grow(Math.max(window.total ?? 0, last + 1))
    window.index.forEach((index, i) => {
      this.x[index] = window.x_mm[i] ?? NaN
      this.y[index] = window.y_mm[i] ?? NaN
      const key = window.key[i]
      if (key === null || key === undefined) return
      const [status, seconds] = [window.status[i] ?? 'waiting', window.seconds[i]]
      this.set({ index, key, status, seconds, tries: window.tries[i], message: window.message[i] })
    })
  }

  /** Apply one change; returns its index. */
  set(change: PointChange): number {
    const { index, key } = change
    this.grow(index + 1)
    const before = this.places.get(key)
    if (before !== undefined && before !== index) this.forget(before)
    this.keys[index] = key
    this.places.set(key, index)
    this.mark(index, CODES.get(change.status) ?? 0)
    this.seconds[index] = change.seconds ?? NaN
    this.tried[index] = change.tries ?? 0
    if (change.message) this.messages.set(index, change.message)
    else this.messages.delete(index)
    return index
  }

  /** The run is over: nothing is under way any more. */
  settle(): void {
    const [running, cancelled] = [CODES.get('running'), CODES.get('cancelled') ?? 0]
    for (let i = 0; i < this.size; i++) if (this.codes[i] === running) this.mark(i, cancelled)
  }

  /** The iterations in which something went wrong, in order. */
  problems(): number[] {
    const found: number[] = []
    for (let i = 0; i < this.size; i++) if (isProblem(this.status(i)) || this.tried[i]) found.push(i)
    return found
  }

  private forget(index: number): void {
    this.keys[index] = null
    this.mark(index, 0)
  }

  private mark(index: number, code: number): void {
    const before = this.codes[index] ?? 0
    this.counts[before] = (this.counts[before] ?? 0) - 1
    this.counts[code] = (this.counts[code] ?? 0) + 1
    this.codes[index] = code
  }

  private grow(size: number): void {
    if (size <= this.size) return
    if (size > this.codes.length) {
      const room = Math.max(size, this.codes.length * 2, 64)
      this.codes = copied(new Uint8Array(room), this.codes)
      this.tried = copied(new Uint16Array(room), this.tried)
      this.seconds = copied(new Float32Array(room).fill(NaN), this.seconds)
      this.x = copied(new Float64Array(room).fill(NaN), this.x)
      this.y = copied(new Float64Array(room).fill(NaN), this.y)
    }
    this.counts[0] = (this.counts[0] ?? 0) + size - this.size
    this.size = size
  }
}

function copied<T extends Uint8Array | Uint16Array | Float32Array | Float64Array>(into: T, from: T): T {
  into.set(from)
  return into
}
