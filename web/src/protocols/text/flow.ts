// Between brackets: insert or remove an item with its commas.
import type { Change } from './land'
import type { Place } from './place'

export function intoFlow(place: Place, at: number, written: string): Change {
  const next = place.items[at]
  const before = place.items[at - 1]
  if (next && at === 0) return { from: next.start, to: next.start, insert: `${written}, ` }
  if (before) return { from: before.end, to: before.end, insert: `, ${written}` }
  return { from: place.from + 1, to: place.from + 1, insert: written }
}

export function outOfFlow(place: Place, index: number): Change {
  const item = place.items[index]
  const next = place.items[index + 1]
  const before = place.items[index - 1]
  const from = next || !before ? (item?.start ?? place.from) : before.end
  return { from, to: next?.start ?? item?.end ?? place.to, insert: '' }
}
