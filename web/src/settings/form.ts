/** The bench's settings as text that a person edits. */
import type { Settings } from '../api/types'

export interface Form { bench: string; operators: string; sizes: string; byHand: string; every: string; lookFor: string; checklists: { danger: string; lines: string }[] }

export function formOf(settings: Pick<Settings, 'bench' | 'operators' | 'step_sizes_mm' | 'by_hand_s' | 'look_every_s' | 'look_for_min' | 'checklists'>): Form {
  return {
    bench: settings.bench,
    operators: settings.operators.join('\n'),
    sizes: settings.step_sizes_mm.join(' '),
    byHand: String(settings.by_hand_s),
    every: String(settings.look_every_s),
    lookFor: String(settings.look_for_min),
    checklists: Object.entries(settings.checklists).map(([danger, lines]) => ({ danger, lines: lines.join('\n') })),
  }
}

/** The form after settings arrived: a field that was edited since `before` stays as it was written, every other takes what came. */
export function kept(form: Form, before: Form, now: Form): Form {
  const one = <T>(written: T | undefined, known: T | undefined, next: T): T =>
    written === undefined || written === known ? next : written
  const lines = (of: Form, danger: string) => of.checklists.find((list) => list.danger === danger)?.lines
  return {
    bench: one(form.bench, before.bench, now.bench),
    operators: one(form.operators, before.operators, now.operators),
    sizes: one(form.sizes, before.sizes, now.sizes),
    byHand: one(form.byHand, before.byHand, now.byHand),
    every: one(form.every, before.every, now.every),
    lookFor: one(form.lookFor, before.lookFor, now.lookFor),
    checklists: now.checklists.map((next) => ({
      ...next, lines: one(lines(form, next.danger), lines(before, next.danger), next.lines),
    })),
  }
}
