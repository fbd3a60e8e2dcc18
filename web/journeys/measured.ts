// A finished run, made through the API, for journeys that look at its results.
import { ask, type Bench } from './bench'

interface Run {
  fate: string
  done: number
}

const UNTIL_MS = 200_000
const TICKED = ['enclosure closed', 'nobody in the beam path', 'sample fixed']

/** Headers of a command. */
export function now(more: Record<string, string> = {}): Record<string, string> {
  return { 'Idempotency-Key': crypto.randomUUID(), 'X-Deadline': String(Date.now() + 50_000), ...more }
}

/** Wait until every device of the bench is online, and no run uses one: a run that has ended still writes its report. */
export async function reached(bench: Bench): Promise<void> {
  for (const end = Date.now() + UNTIL_MS; Date.now() < end; await rest()) {
    const devices = await ask<{ reach: string; used_by: string | null }[]>(bench, '/devices')
    if (devices.length && devices.every((device) => device.reach === 'online' && device.used_by === null)) return
  }
  throw new Error('a device did not come up')
}

/** Start a protocol under a new name; returns the run's id. */
export async function startRun(bench: Bench, protocol: string, params: Record<string, string> = {}): Promise<string> {
  await reached(bench)
  const { lease } = await ask<{ lease: string }>(bench, '/control/take', { name: 'Program', reason: 'a journey' })
  const held = { 'X-Control-Lease': lease }
  const launch = await ask<{ id: string; run: string | null }>(bench, '/runs', { protocol, params, operator: 'Ada', checklist: TICKED }, now(held))
    .finally(() => ask(bench, '/control/release', {}, held))
  let run = launch.run
  for (const until = Date.now() + UNTIL_MS; run === null && Date.now() < until; await rest()) {
    run = (await ask<{ run: string | null }>(bench, `/launches/${launch.id}`)).run
  }
  if (run === null) throw new Error(`${protocol} did not come up`)
  return run.split('/').at(-1) ?? run
}

/** Wait until a run has the expected fate. */
export async function until(bench: Bench, run: string, is: (run: Run) => boolean): Promise<Run> {
  let last = ''
  for (const end = Date.now() + UNTIL_MS; Date.now() < end; await rest()) {
    const told = await ask<Run>(bench, `/runs/${run}`)
    if (is(told)) return told
    last = `${told.fate} after ${told.done}`
  }
  throw new Error(`${run} did not become what it was to: ${last}`)
}

/** A small map of a pegmatite, measured completely. */
export async function measuredMap(bench: Bench): Promise<string> {
  const run = await startRun(bench, 'pegmatite_map.yaml', { width: '1 mm', height: '1.4 mm' })
  await until(bench, run, (told) => told.fate === 'succeeded')
  return run
}

const rest = (): Promise<void> => new Promise((resolve) => setTimeout(resolve, 300))
