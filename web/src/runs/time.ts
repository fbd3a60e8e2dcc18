// Times and durations as text: short, and only as precise as they are known.

/** `0.2 s`, `12 s`, `3 min 20 s`, `4 h 06 min`. */
export function duration(seconds: number): string {
  if (seconds < 0.095) return `${Math.round(seconds * 1000)} ms`
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`
  const whole = Math.round(seconds)
  if (whole < 60) return `${whole} s`
  if (whole < 3600) {
    const rest = whole % 60
    return rest && whole < 600 ? `${Math.floor(whole / 60)} min ${rest} s` : `${Math.round(whole / 60)} min`
  }
  const minutes = Math.round(whole / 60)
  return `${Math.floor(minutes / 60)} h ${String(minutes % 60).padStart(2, '0')} min`
}

/** `16:10`; with seconds for what is near; with the date if it is another day. */
export function clock(at: Date, now: Date, seconds = false): string {
  const time = `${two(at.getHours())}:${two(at.getMinutes())}${seconds ? `:${two(at.getSeconds())}` : ''}`
  const days = Math.round((startOfDay(at) - startOfDay(now)) / 86_400_000)
  if (days === 0) return time
  if (days === 1) return `tomorrow ${time}`
  if (days === -1) return `yesterday ${time}`
  return `${at.getFullYear()}-${two(at.getMonth() + 1)}-${two(at.getDate())} ${time}`
}

/** A range of instants: `16:10–16:25`, `16:10` where both ends are the same minute. */
export function clockRange(low: Date, high: Date, now: Date): string {
  const near = high.getTime() - now.getTime() < 180_000
  const [from, to] = [clock(low, now, near), clock(high, now, near)]
  if (from === to) return from
  const sameDay = startOfDay(low) === startOfDay(high)
  return `${from}–${sameDay ? (to.split(' ').at(-1) ?? to) : to}`
}

/** When a run will be over, as shown in the strip. */
export function etaWords(eta: readonly [string, string] | null | undefined, now: Date): string {
  if (!eta) return ''
  return `ends ${clockRange(new Date(eta[0]), new Date(eta[1]), now)}`
}

/** `in 12 min`, `now` for what is due: how long until a person is needed. */
export function until(at: Date, now: Date): string {
  const seconds = (at.getTime() - now.getTime()) / 1000
  return seconds < 5 ? 'now' : `in ${duration(seconds)}`
}

function startOfDay(at: Date): number {
  return new Date(at.getFullYear(), at.getMonth(), at.getDate()).getTime()
}

function two(n: number): string {
  return String(n).padStart(2, '0')
}
