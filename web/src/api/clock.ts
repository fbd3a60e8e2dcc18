// The server's clock as seen from here: deadlines and ages count by it, whatever this machine's says.
const KEPT_MS = 60_000

let samples: { at: number; offset: number }[] = []

/** Note what the server's clock said just now. A message under way makes it look slow, never fast. */
export function heardTime(server_time_ms: number, now = Date.now()): void {
  samples = samples.filter((one) => now - one.at >= 0 && now - one.at < KEPT_MS)
  samples.push({ at: now, offset: server_time_ms - now })
}

/** The server's time now, in ms since 1970; ours where it has not said. */
export function serverNow(now = Date.now()): number {
  if (samples.length === 0) return now
  return now + Math.max(...samples.map((one) => one.offset))
}

/** Forget what was heard. */
export function forgetTime(): void {
  samples = []
}
