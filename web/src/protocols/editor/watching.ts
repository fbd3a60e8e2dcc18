// What happens when a watched condition holds: four ways that a form knows; anything else stays as it is written.
import { isMap } from '../text/path'

export type Way = 'fail' | 'tell' | 'tell and fail' | 'pause'

export const WAYS: [Way, string][] = [
  ['fail', 'stop the steps and fail:'],
  ['tell and fail', 'tell people and fail:'],
  ['tell', 'tell people, and go on:'],
  ['pause', 'pause the run'],
]

/** Null where it is more than the form has words for. */
export function wayOf(then: unknown): { way: Way; text: string } | null {
  if (then === 'pause') return { way: 'pause', text: '' }
  const steps: unknown[] = Array.isArray(then) ? then : [then]
  const texts = steps.map((step) => {
    const [[key, text] = ['', null], more] = isMap(step) ? Object.entries(step) : []
    return (key === 'fail' || key === 'notify') && typeof text === 'string' && more === undefined ? { key, text } : null
  })
  const [first, second] = texts
  if (!first || texts.length > 2 || second === null) return null
  if (!second) return { way: first.key === 'fail' ? 'fail' : 'tell', text: first.text }
  return first.key === 'notify' && second.key === 'fail' && first.text === second.text ? { way: 'tell and fail', text: first.text } : null
}

export function writtenWay(way: Way, text: string): unknown {
  switch (way) {
    case 'pause': return 'pause'
    case 'fail': return { fail: text }
    case 'tell': return { notify: text }
    case 'tell and fail': return [{ notify: text }, { fail: text }]
  }
}
