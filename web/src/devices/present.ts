// The present value of a parameter from the status field of the same name: for Teach.
import type { DeviceDetail, DeviceState } from '../api/types'
import type { Field } from './form/fields'
import type { Schema } from './form/schema'

/** The present value of each number field whose name and unit occur in the status. */
export function presentValues(
  fields: readonly Field[], device: DeviceState | undefined, detail: DeviceDetail,
): Record<string, string> {
  const known = (detail.status_schema as Schema).properties ?? {}
  const present: Record<string, string> = {}
  for (const field of fields) {
    const value = device?.status[field.name]
    const same = known[field.name] !== undefined && (known[field.name]?.unit ?? '') === field.unit
    if (field.kind === 'number' && same && typeof value === 'number') present[field.name] = String(Number(value.toFixed(4)))
  }
  return present
}
