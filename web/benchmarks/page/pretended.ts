// A fake server: answers for a run with a given number of points, and a connection that delivers patches.
import type { Socket } from 'socket.io-client'
import type { Received, RunDetail, RunPatch, Snapshot, WatchedRun } from '../../src/api/types'

export const RUN = 'bench'
export const LOOP = 'main/scan'
export const CHANNELS = 22_800

/** A run of `width` × `height` points, none of them done. */
export class Pretended {
  readonly total: number
  private seq = 0
  private readonly tellers = new Map<string, Set<(data: unknown) => void>>()

  constructor(private readonly width: number, height: number) {
    this.total = width * height
  }

  /** The connection, as far as the page uses it. */
  socket(): Socket {
    const ask = (event: string): unknown => (event === 'watch' ? ({ ok: true, text: '', run: this.detail() } satisfies WatchedRun) : event === 'snapshot' ? this.snapshot() : null)
    const emitter = { emit: () => undefined, timeout: () => ({ emitWithAck: (event: string) => Promise.resolve(ask(event)) }) }
    const line = {
      connected: true, volatile: emitter,
      on: (event: string, tell: (data: unknown) => void) => this.heard(event).add(tell),
      off: (event: string, tell: (data: unknown) => void) => this.heard(event).delete(tell),
      connect: () => {
        this.tell('connect', null)
        this.tell('snapshot', this.snapshot())
      },
      disconnect: () => line,
    }
    return line as unknown as Socket
  }

  /** Send a patch with points that are done. */
  done(indexes: readonly number[], done: number): RunPatch {
    this.seq += 1
    const node: Received<'NodeState'> = { status: 'running', running: 1, ok: done, failed: 0, skipped: 0, unknown: 0, retries: 0, last_s: 6.1, message: '' }
    const patch: RunPatch = {
      run: RUN, seq: this.seq, head: { ...this.detail(), done, measured: done, left: this.total - done }, nodes: { 'main/scan/*/shoot': node },
      points: indexes.map((index) => ({ loop: LOOP, within: '', index, key: String(index), status: 'ok', seconds: 6, tries: 0, message: '' })),
    }
    this.tell('run_patch', patch)
    return patch
  }

  /** Answers to HTTP requests. */
  answer(path: string, query: URLSearchParams): Response {
    if (path.endsWith('/points')) return Response.json(this.points(Number(query.get('offset')), Number(query.get('limit'))))
    if (path.endsWith('/log')) return Response.json({ lines: [], total: 0, more_before: false })
    if (path.endsWith('/maps')) return Response.json({ maps: [], cell_keys: {} })
    return Response.json({ code: 'NONE', message: 'not in the fake server', hint: '', problems: [], details: {} }, { status: 404 })
  }

  private heard(event: string): Set<(data: unknown) => void> {
    const known = this.tellers.get(event) ?? new Set()
    this.tellers.set(event, known)
    return known
  }

  private tell(event: string, data: unknown): void {
    this.heard(event).forEach((one) => one(data))
  }

  private points(offset: number, limit: number): Received<'Points'> {
    const index = Array.from({ length: Math.max(0, Math.min(limit, this.total - offset)) }, (_, i) => offset + i)
    const fill = <T>(value: T): T[] => index.map(() => value)
    return {
      loop: LOOP, total: this.total, offset, index, key: fill(null), status: fill('waiting'), seconds: fill(null), tries: fill(0), message: fill(''),
      x_mm: index.map((i) => (i % this.width) * 0.2), y_mm: index.map((i) => Math.floor(i / this.width) * 0.2),
    }
  }

  private detail(): RunDetail {
    const step = (path: string, parent: string | null, depth: number, loop: boolean): Received<'OutlineNode'> => ({
      path, parent, depth, kind: loop ? 'foreach' : 'do', id: null, title: path, role: null, action: null, danger: null, loop, line: 1, pointer: null,
    })
    return {
      id: RUN, protocol: 'benchmark', file: 'benchmark.yaml', fate: 'running', reason: '', live: true, began_at: new Date().toISOString(), ended_at: null,
      word: 'running', done: 0, measured: 0, failed: 0, left: this.total, total: this.total, holes: 0, resumes: 0, operator: '', questions: 0, now: '', eta: null,
      phase: 'main', pausing: false,
      loops: [{ path: LOOP, title: 'scan', total: this.total, done: 0, succeeded: 0, failed: 0, skipped: 0, current: '0', placed: true }],
      under_way: [], open_questions: [], needs_you: null, per_minute: 10, retries: 0, lines: 0, stands: false, nodes: {}, params: {}, roles: {}, outputs: {},
      outline: [step(LOOP, null, 0, true), ...['lift', 'travel', 'lower', 'shoot', 'export'].map((name) => step(`${LOOP}/*/${name}`, LOOP, 1, false))],
      launch: { operator: '', note: '', checklist: [], at: '' }, protocol_text: '', changes: 0, seq: this.seq,
    }
  }

  private snapshot(): Snapshot {
    return { seq: 0, server_time_ms: Date.now(), bench: 'benchmark', devices: {}, runs: {}, goals: {}, jogs: {}, launches: {}, control: { holder: null, since: null, ends_at: null, armed: false } }
  }
}
