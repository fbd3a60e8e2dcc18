// Why a run cannot start on these devices, and where to fix it.
import type { DeviceState, Received } from '../../api/types'

export interface DeviceCheck {
  role: string
  device: string
  word: string
  /** Empty if the device is free. */
  blocker: string
  /** The run that holds it, if it has begun. */
  run: string | null
}

/** Each role with its device, and what prevents the start. */
export function deviceChecks(
  roles: readonly Received<'RoleForm'>[], bound: Readonly<Record<string, string>>,
  devices: Readonly<Record<string, DeviceState>>,
): DeviceCheck[] {
  return roles.map(({ role, contract, device }) => {
    const name = bound[role] ?? device
    if (name === null) return check(role, '', 'none', `no device in this lab is a ${contract}`)
    const state = devices[name]
    if (!state) return check(role, name, 'unknown', `${name} is unknown to the server`)
    if (state.reach !== 'online') return check(role, name, state.reach, state.reason || `${name} is ${state.reach}`)
    if (state.used_by) return { ...check(role, name, state.word, `${name} is used by ${state.used_by}`), run: state.used_by.includes(' ') ? null : state.used_by }
    if (state.goal) return check(role, name, state.word, `${name} is busy with a manual action`)
    return check(role, name, state.word, '')
  })
}

function check(role: string, device: string, word: string, blocker: string): DeviceCheck {
  return { role, device, word, blocker, run: null }
}

/** The checklist items to tick before a run with these dangers, each once. */
export function checklist(
  dangers: readonly string[], lists: Readonly<Record<string, readonly string[]>>,
): string[] {
  return [...new Set(dangers.flatMap((danger) => lists[danger] ?? []))]
}
