// Steps done by hand or recorded, inserted after the selected row: one change, one undo.
import { parse } from 'yaml'
import type { useIntake } from '../intake'
import type { Edit } from '../text/edit'
import { isMap } from '../text/path'
import { roleFor } from './adding'
import type { Editing } from './editing'
import { placeAfter } from './moves'

type Intake = ReturnType<typeof useIntake>

/** A sentence on what was done; empty if nothing had come. */
export function takeIn(editing: Editing, intake: Intake): string {
  if (intake.count === 0 || editing.locked.value || editing.broken.value) return ''
  const came = intake.take()
  const roles = editing.checking.checked.value?.roles ?? []
  const edits: Edit[] = []
  const values: unknown[] = []
  for (const { step, device, contract } of came) {
    const { role, edits: first } = roleFor(editing.good.value?.data, { name: device, contract }, roles)
    if (!edits.some((one) => JSON.stringify(one) === JSON.stringify(first[0]))) edits.push(...first)
    values.push(...stepsIn(step).map((one) => (isMap(one) && typeof one['do'] === 'string' ? { ...one, do: `${role}.${one['do'].split('.').at(-1) ?? ''}` } : one)))
  }
  const { list, index } = placeAfter(editing.good.value?.data, editing.selectedPath.value, false)
  if (!editing.edit(...edits, { kind: 'insert', path: list, index, values })) return ''
  return `${String(values.length)} ${values.length === 1 ? 'step was' : 'steps were'} added.`
}

/** The server sends one step, or a list of one. */
export function stepsIn(step: string): unknown[] {
  const told = parse(step) as unknown
  return Array.isArray(told) ? (told as unknown[]) : [told]
}
