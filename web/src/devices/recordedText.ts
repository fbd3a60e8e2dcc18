// Recorded steps as the text of a new protocol.
import type { Came } from '../protocols/intake'

/** A protocol that does the steps in their order. */
export function protocolOf(name: string, steps: readonly Came[], at = new Date()): string {
  const roles = [...new Map(steps.map((one) => [one.device, one.contract]))]
  const day = at.toISOString().slice(0, 10)
  return [
    'labrun: 1',
    `name: ${name.split('/').at(-1) ?? name}`,
    `summary: Recorded by hand on ${day}`,
    'devices:',
    ...roles.map(([role, contract]) => `  ${role}: ${contract}`),
    'steps:',
    ...steps.map((one) => `  - ${one.step}`),
    '',
  ].join('\n')
}
