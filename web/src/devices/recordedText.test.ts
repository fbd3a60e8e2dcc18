import { expect, it } from 'vitest'
import { parse } from 'yaml'
import { protocolOf } from './recordedText'

it('recorded steps are a protocol with the devices that they need', () => {
  const steps = [
    { step: '{do: gantry.move_to, with: {x: 10.5}}', device: 'gantry', contract: 'gantry@1' },
    { step: '{do: libs.measure}', device: 'libs', contract: 'libs_analyzer@1' },
    { step: '{do: gantry.home}', device: 'gantry', contract: 'gantry@1' },
  ]
  const read = parse(protocolOf('sub/first try', steps, new Date('2026-11-21T12:00:00Z'))) as Record<string, unknown>

  expect(read).toEqual({
    labrun: 1,
    name: 'first try',
    summary: 'Recorded by hand on 2026-11-21',
    devices: { gantry: 'gantry@1', libs: 'libs_analyzer@1' },
    steps: [{ do: 'gantry.move_to', with: { x: 10.5 } }, { do: 'libs.measure' }, { do: 'gantry.home' }],
  })
})
