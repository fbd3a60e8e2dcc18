// A protocol of steps that were done by hand.
import type { Came } from '../intake'

/** The steps as they were told, in order, with a role for each device. */
export function recordedText(file: string, steps: readonly Came[]): string {
  const name = file.replace(/^.*\//, '').replace(/\.(ya?ml|json)$/i, '').replace(/[^A-Za-z0-9 _.-]/g, '-').replace(/^[^A-Za-z0-9]+/, '') || 'recorded'
  const roles = new Map<string, { contract: string; role: string }>()
  for (const { device, contract } of steps) roles.set(device, { contract, role: device.replace(/\W/g, '_') })
  const devices = [...roles.values()].map(({ role, contract }) => `  ${role}: ${contract}`)
  return [
    `# Recorded by hand.`, 'labrun: 1', `name: ${name}`, '', 'devices:', ...devices, '', 'steps:', ...steps.map(({ step }) => asItem(step)), '',
  ].join('\n')
}

/** One step, or a list of one, as an item at two spaces. */
function asItem(step: string): string {
  const lines = step.trimEnd().split('\n')
  const listed = lines[0]?.startsWith('- ') === true
  return lines.map((line, i) => (listed ? `  ${line}` : i === 0 ? `  - ${line}` : `    ${line}`)).join('\n')
}
