// Amounts and duration in brief, before anything moves.
import type { Received } from '../../api/types'
import { clockRange, duration } from '../time'
import { counted } from '../../ui/format'

type Preview = Received<'Preview'>

/** `4 h 15 min – 4 h 40 min (measured on 3 runs)`; of quick simulated devices also what real ones take, as a rehearsal has found or by what is typical. */
export function spanWords(time: Preview['time_s'], rehearsed: number | null = null): string {
  const found = rehearsed === null ? '' : `${duration(rehearsed)} (rehearsed)`
  if (!time || (found && time.real_s === null && time.runs === 0)) return found || 'not known in advance'
  const [low, high] = [duration(time.low), duration(time.high)]
  const from = time.runs ? `measured on ${time.runs} ${time.runs === 1 ? 'run' : 'runs'}` : 'typical'
  const span = time.high === 0 ? 'a moment' : `${low === high ? low : `${low} – ${high}`} (${from})`
  return time.real_s === null ? span : `${found || `${duration(time.real_s)} (typical)`} with real devices; ${span} with these simulated ones`
}

/** The same, and when it would end if it started now. */
export function timeWords({ time_s: time }: Preview, now: Date): string {
  const at = (s: number): Date => new Date(now.getTime() + s * 1000)
  return `Time: ${spanWords(time)}${time ? `, ends ${clockRange(at(time.low), at(time.high), now)}` : ''}`
}

/** `1,071 points · 1,071 shots`. */
export function amountWords(preview: Preview): string {
  const points = Math.max(0, ...preview.tracks.map((track) => track.x_mm.length))
  const outside = preview.tracks.reduce((sum, track) => sum + track.outside.length, 0)
  return [
    points ? `${counted(points, 'point')}${preview.full ? ' and more' : ''}` : '',
    preview.shots ? counted(preview.shots, 'laser shot') : '',
    outside ? `${outside.toLocaleString('en')} outside the work area` : '',
    preview.needs_you.length ? 'needs you' : 'runs unattended',
  ].filter(Boolean).join(' · ')
}
