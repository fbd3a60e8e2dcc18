// The state of a device as shape, word and colour, never colour alone.
import type { DeviceState } from '../api/types'

export interface Sight {
  shape: string
  word: string
  tone: 'ok' | 'warn' | 'fail' | 'accent' | 'muted' | 'paused'
}

const TROUBLE = new Set(['alarm', 'error', 'fault', 'failed', 'offline', 'disconnected'])
const AT_WORK = new Set(['busy', 'moving', 'homing', 'measuring', 'running'])

/** What to show for a device. */
export function sightOf(device: Pick<DeviceState, 'reach' | 'word' | 'used_by' | 'armed'>): Sight {
  if (device.reach === 'lost') return { shape: '✕', word: 'lost', tone: 'fail' }
  if (device.reach === 'failed') return { shape: '✕', word: 'failed', tone: 'fail' }
  if (device.reach === 'starting') return { shape: '◌', word: 'starting', tone: 'muted' }
  const word = device.word
  if (device.armed !== null || word.toLowerCase() === 'armed') return { shape: '☀', word: 'ARMED', tone: 'warn' }
  if (TROUBLE.has(word.toLowerCase())) return { shape: '▲', word, tone: 'fail' }
  if (AT_WORK.has(word.toLowerCase()) || device.used_by !== null) return { shape: '■', word, tone: 'accent' }
  return { shape: '●', word, tone: 'ok' }
}
