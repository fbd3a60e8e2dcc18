// The axes of a device that can be jogged: position, travel, and the action that moves them.
import type { ActionForm, DeviceDetail, DeviceState } from '../../api/types'
import type { Schema } from '../form/schema'

export type Axis = 'x' | 'y' | 'z'
export type Place = Partial<Record<Axis, number>>
/** Axes that a jog moves together, and their directions. */
export type Way = Partial<Record<Axis, 1 | -1>>

/** The position in mm from the latest status; unknown axes are left out. */
export function placeOf(device: DeviceState, axes: readonly Axis[]): Place {
  const place: Place = {}
  for (const axis of axes) {
    const value = device.status[axis]
    if (typeof value === 'number') place[axis] = value
  }
  return place
}

/** The action that moves to a position: it moves, can be cancelled, and takes the axes. */
export function movingOf(detail: DeviceDetail): ActionForm | undefined {
  return detail.actions.find((action) => {
    const known = (action.params as Schema).properties ?? {}
    return action.danger === 'motion' && action.cancel && detail.axes.some((axis) => axis in known)
  })
}

/** Whether it jogs several axes at once. */
export function jogsSeveral(detail: DeviceDetail): boolean {
  const jog = detail.actions.find((action) => action.name === 'jog')
  return 'way' in ((jog?.params as Schema | undefined)?.properties ?? {})
}

/** The largest feed that the move takes, in mm/min; null if it takes none. */
export function mostFeed(moving: ActionForm | undefined): number | null {
  const feed = (moving?.params as Schema | undefined)?.properties?.['feed']
  return feed?.unit === 'mm/min' ? (feed.maximum ?? null) : null
}

/** The zero that the device itself counts from, in bench coordinates; axes that use the bench's zero are left out. */
export function zeroOf(device: DeviceState, axes: readonly Axis[]): Place {
  const zero: Place = {}
  for (const axis of axes) {
    const [at, from] = [device.status[axis], device.status[`work_${axis}`]]
    if (typeof at === 'number' && typeof from === 'number' && Math.abs(at - from) > 1e-6) zero[axis] = at - from
  }
  return zero
}

/** Actions that hold and resume a move: buttons beside the move, not cards. */
export const PAUSING = ['hold', 'resume'] as const
