// A separate simulated bench for each journey file: `labrun web --demo` on a free port.
import { type ChildProcess, spawn } from 'node:child_process'
import { existsSync } from 'node:fs'
import { mkdtemp, writeFile } from 'node:fs/promises'
import { tmpdir } from 'node:os'
import { join } from 'node:path'
import { fileURLToPath } from 'node:url'

const ROOT = fileURLToPath(new URL('../..', import.meta.url))
const READY_MS = 90_000
const END_MS = 20_000

export interface Bench {
  /** Without the token. */
  address: string
  /** What it printed, for a person to open: with the token that it has made, if any. */
  entry: string
  port: number
  process: ChildProcess
  /** Send a signal to the server alone, for example SIGSTOP or SIGKILL. */
  signal(name: NodeJS.Signals): void
  close(): Promise<void>
}

/** The `labrun` to test: LABRUN, the repository's own environment, or the one on PATH. */
function command(): string {
  const own = `${ROOT}.venv/bin/labrun`
  return process.env['LABRUN'] ?? (existsSync(own) ? own : 'labrun')
}

/** Start a bench; `speed` is how fast its clock runs. */
export async function startBench({ speed = 50, port = 0, args = ['--demo', '--speed', String(speed)], cwd = ROOT } = {}): Promise<Bench> {
  const child = spawn(command(), ['web', ...args, '--no-browser', '--port', String(port)], {
    cwd, stdio: ['ignore', 'pipe', 'pipe'],
  })
  const entry = await firstAddress(child)
  const { origin, port: bound } = new URL(entry)
  return {
    address: origin,
    entry,
    port: Number(bound),
    process: child,
    signal: (name) => child.kill(name),
    close: () => end(child),
  }
}

/** A folder with a lab of a gantry alone, where a server is looked at, not its devices: eighteen take long to start. */
export async function aGantryAlone(): Promise<string> {
  const folder = await mkdtemp(join(tmpdir(), 'labrun-journey-'))
  await writeFile(join(folder, 'lab.yaml'), [
    'name: gantry', 'summary: A gantry alone', 'simulated: true', 'devices:', '  gantry: {contract: gantry@1, driver: sim_gantry, config: {homed: true}}', '',
  ].join('\n'))
  return folder
}

function firstAddress(child: ChildProcess): Promise<string> {
  return new Promise((resolve, reject) => {
    let said = ''
    const late = setTimeout(() => reject(new Error(`labrun web did not come up:\n${said}`)), READY_MS)
    const hear = (chunk: Buffer): void => {
      said += chunk.toString()
      const found = /http:\/\/[^\s;]+/.exec(said)
      if (found === null) return
      clearTimeout(late)
      resolve(found[0])
    }
    child.stdout?.on('data', hear)
    child.stderr?.on('data', hear)
    child.once('error', (error) => {
      clearTimeout(late)
      reject(new Error(`labrun was not found (${error.message}): install it, or set LABRUN`))
    })
    child.once('exit', (code) => {
      clearTimeout(late)
      reject(new Error(`labrun web ended with ${code}:\n${said}`))
    })
  })
}

async function end(child: ChildProcess): Promise<void> {
  if (child.exitCode !== null || child.signalCode !== null) return
  const over = new Promise<void>((resolve) => child.once('exit', () => resolve()))
  child.kill('SIGCONT')
  child.kill('SIGTERM')
  const late = setTimeout(() => child.kill('SIGKILL'), END_MS)
  await over
  clearTimeout(late)
}

/** What a program sends that knows the token in the printed address; without one it asks for a session, as a browser does. */
export async function letIn(bench: Bench): Promise<Record<string, string>> {
  const token = new URL(bench.entry).searchParams.get('token')
  if (token !== null) return { Authorization: `Bearer ${token}` }
  const session = await fetch(`${bench.address}/api/v1/session`)
  return { cookie: session.headers.getSetCookie().map((one) => one.split(';')[0]).join('; ') }
}

/** Send a request to the API as a program does. */
export async function ask<T>(bench: Bench, path: string, body?: unknown, headers: Record<string, string> = {}): Promise<T> {
  const response = await fetch(`${bench.address}/api/v1${path}`, {
    method: body === undefined ? 'GET' : 'POST',
    headers: { ...(await letIn(bench)), 'content-type': 'application/json', ...headers },
    ...(body === undefined ? {} : { body: JSON.stringify(body) }),
  })
  if (!response.ok) throw new Error(`${path}: ${response.status} ${await response.text()}`)
  return (await response.json()) as T
}

/** Inject a fault on the simulated bench. */
export async function orderFault(bench: Bench, fault: Record<string, unknown>): Promise<void> {
  await ask(bench, '/demo/fault', fault, { 'Idempotency-Key': crypto.randomUUID() })
}
