import { expect, test } from 'vitest'
import type { DeviceState } from '../../api/types'
import { checklist, deviceChecks } from './blockers'

const device = (more: Partial<DeviceState>): DeviceState =>
  ({ reach: 'online', word: 'idle', reason: '', used_by: null, goal: null, ...more }) as DeviceState
const role = (name: string, on: string | null) => ({ role: name, contract: `${name}@1`, device: on, choices: [] })

test('what prevents the start is reported for each device', () => {
  const roles = [role('gantry', 'gantry'), role('libs', 'libs'), role('camera', 'camera'), role('scale', null)]
  const checks = deviceChecks(roles, {}, {
    gantry: device({}), libs: device({ used_by: 'r1' }), camera: device({ reach: 'lost', reason: 'no answer for 9 s' }),
  })

  expect(checks.map((one) => one.blocker)).toEqual([
    '', 'libs is used by r1', 'no answer for 9 s', 'no device in this lab is a scale@1',
  ])
  expect(checks[1]?.run).toBe('r1')
})

test('another device can be chosen', () => {
  const [check] = deviceChecks([role('gantry', 'gantry')], { gantry: 'gantry_b' }, { gantry_b: device({ goal: 'g1' }) })

  expect(check?.blocker).toBe('gantry_b is busy with a manual action')
})

test('an item on two lists is ticked once, and a danger without a list has none', () => {
  expect(checklist(['laser', 'laser', 'heat', 'motion'], { laser: ['a', 'b'], heat: ['b', 'c'] })).toEqual(['a', 'b', 'c'])
})
