// The server's clock as seen from here: deadlines and ages use it, not this machine's clock.
const KEPT_MS = 60_000

let samples: { at: number; offset: number }[] = []

/** Note the time that the server just sent. Transmission makes its clock look slow, never fast. */
export function heardTime(server_time_ms: number, now = Date.now()): void {
  samples = samples.filter((one) => now - one.at >= 0 && now - one.at < KEPT_MS)
  samples.push({ at: now, offset: server_time_ms - now })
}

/** The server's time now, in ms since 1970; ours if it has not sent one. */
export function serverNow(now = Date.now()): number {
  if (samples.length === 0) return now
  return now + Math.max(...samples.map((one) => one.offset))
}

/** Forget the times received. */
export function forgetTime(): void {
  samples = []
}
