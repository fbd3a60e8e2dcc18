// One protocol being edited: its text is the only state; rows, problems and selection follow from it.
import { redoDepth, undoDepth } from '@codemirror/commands'
import { setDiagnostics, type Diagnostic } from '@codemirror/lint'
import { Annotation, EditorSelection, StateEffect, type ChangeDesc } from '@codemirror/state'
import { EditorView, type ViewUpdate } from '@codemirror/view'
import { computed, onScopeDispose, ref, shallowRef, watch } from 'vue'
import { lastOfAll, patchAll, type Edit } from '../text/edit'
import { firstOn, rangeOf, RowIndex } from '../text/finding'
import { samePath, startsWith, toPointer, valueAt, type Path } from '../text/path'
import { read, type Broken, type Read } from '../text/reading'
import { rowsOf } from '../text/rows'
import type { Contracts } from './contracts'
import { useChecking } from './checking'
import { moved, type Found } from './problems'
import { readOnly, redo, stateOf, undo, writable } from './view'

const PARSE_MS = 120
const VISUAL = Annotation.define<boolean>()

export interface Hosts {
  name: string
  contracts: Contracts
  /** Requested by the person, by key. */
  save(): void
  refuse(reason: string): void
}

export function useEditing(first: string, { name, contracts, save, refuse }: Hosts) {
  const text = shallowRef(first)
  const good = shallowRef<Read | null>(null)
  const broken = shallowRef<Broken | null>(null)
  const caret = ref(0)
  const depths = ref({ undo: 0, redo: 0 })
  const locked = ref(false)
  const rows = computed(() => (good.value ? rowsOf(good.value) : []))
  const index = computed(() => new RowIndex(rows.value))
  const selected = ref(0)
  const selectedPath = computed<Path>(() => rows.value[selected.value]?.path ?? [])
  let timer: ReturnType<typeof setTimeout> | undefined

  const view = new EditorView({ state: stateOf(first, { save, fix: fixHere }, EditorView.updateListener.of(updated)) })
  const checking = useChecking(name)
  /** Nothing was added yet: a beginning, not a mistake. */
  const blank = computed(() => {
    const steps = valueAt(good.value?.data, ['steps'])
    return Array.isArray(steps) && steps.length === 0
  })
  const problems = computed<readonly Found[]>(() => {
    const all = checking.problems.value
    return blank.value ? all.filter((one) => one.pointer !== '/steps') : all
  })

  function updated(update: ViewUpdate): void {
    if (update.docChanged) {
      text.value = update.state.doc.toString()
      checking.moved((all) => moved(all, update.changes as ChangeDesc, (at) => update.state.doc.lineAt(Math.min(at, update.state.doc.length)).number))
      clearTimeout(timer)
      const visual = update.transactions.some((one) => one.annotation(VISUAL) === true)
      if (visual) parse()
      else timer = setTimeout(parse, PARSE_MS)
      checking.soon(text.value)
    }
    if (update.docChanged || update.selectionSet) follow(update.state.selection.main.head)
    depths.value = { undo: undoDepth(update.state), redo: redoDepth(update.state) }
  }

  /** The selected row is the one that the caret is in; a broken text keeps its last rows. */
  function follow(at: number): void {
    caret.value = at
    if (good.value?.text !== text.value) return
    const found = index.value.at(at)
    if (found >= 0) selected.value = found
  }

  function parse(): void {
    clearTimeout(timer)
    const now = read(text.value)
    if (now.ok) {
      good.value = now
      broken.value = null
      follow(view.state.selection.main.head)
    } else broken.value = now
    checking.local(now)
  }

  function diagnostics(): Diagnostic[] {
    const length = view.state.doc.length
    return problems.value.map((one) => ({
      from: Math.min(one.from, length), to: Math.min(one.to, length), severity: one.severity, source: one.code,
      message: one.hint ? `${one.message}. ${one.hint}` : one.message,
      actions: one.fix ? [{ name: one.fix.label, apply: () => mend(one) }] : [],
    }))
  }

  watch(problems, () => view.dispatch(setDiagnostics(view.state, diagnostics())))

  /** Carry out a visual edit as a change of the text; reports why if it is impossible. */
  function edit(...wanted: Edit[]): boolean {
    if (locked.value) return refuse('the protocol is read-only here'), false
    if (good.value?.text !== text.value) parse()
    const done = patchAll(text.value, wanted)
    if (!done.ok) return refuse(done.reason), false
    if (done.changes.length === 0) return true
    const now = read(done.text)
    const at = now.ok ? rangeOf(now, done.select)?.from : undefined
    view.dispatch({
      changes: done.changes, userEvent: `visual.${wanted.at(-1)?.kind ?? 'edit'}`, annotations: VISUAL.of(true), scrollIntoView: true,
      ...(at === undefined ? {} : { selection: EditorSelection.cursor(at) }),
    })
    return true
  }

  /** Select the value at a path: its row, and the caret at its text. */
  function select(path: Path, { focus = false } = {}): void {
    if (!good.value) return
    const row = index.value.of(path)
    if (row >= 0) selected.value = row
    const range = rangeOf(good.value, path)
    if (!range || good.value.text !== text.value) return
    const at = good.value.root && path.length === 0 ? (rows.value[0]?.from ?? range.from) : range.from
    view.dispatch({ selection: EditorSelection.cursor(at), effects: EditorView.scrollIntoView(at, { y: 'center' }) })
    if (focus) view.focus()
  }

  function goTo(from: number, to = from): void {
    const length = view.state.doc.length
    view.dispatch({ selection: EditorSelection.single(Math.min(from, length), Math.min(to, length)), effects: EditorView.scrollIntoView(Math.min(from, length), { y: 'center' }) })
    view.focus()
  }

  function goToLine(number: number): void {
    const line = view.state.doc.line(Math.max(1, Math.min(number, view.state.doc.lines)))
    goTo(line.from + firstOn(line.text))
  }

  function mend(problem: Found): void {
    const { fix } = problem
    if (!fix || locked.value) return
    if (fix.atEnd !== undefined) return void edit(...lastOfAll(good.value?.data, { do: fix.atEnd, on_error: 'continue' }))
    view.dispatch({ changes: { from: fix.from, to: fix.to, insert: fix.insert }, userEvent: 'input.fix', annotations: VISUAL.of(true) })
  }

  function fixHere(): boolean {
    const at = view.state.selection.main.head
    const here = problems.value.find((one) => one.fix !== null && one.from <= at && at <= one.to)
    if (here) mend(here)
    return here !== undefined
  }

  /** Make it this text, as one change that can be undone; what is alike at both ends stays, and the caret in it. */
  function replaceAll(now: string): void {
    const before = view.state.doc.toString()
    let [from, to] = [0, 0]
    while (from < Math.min(before.length, now.length) && before[from] === now[from]) from++
    while (to < Math.min(before.length, now.length) - from && before.at(-1 - to) === now.at(-1 - to)) to++
    view.dispatch({ changes: { from, to: before.length - to, insert: now.slice(from, now.length - to) }, userEvent: 'input.replace', annotations: VISUAL.of(true) })
  }

  /** The problems of a row: of its own values, and those inside if it is closed. */
  function problemsOf(path: Path, within: boolean): Found[] {
    const row = index.value.of(path)
    return problems.value.filter((one) => {
      if (one.pointer === null) return false
      const parts = one.pointer.split('/').slice(1).map((part) => (/^\d+$/.test(part) ? Number(part) : part))
      return index.value.of(parts) === row || (within && startsWith(parts, path))
    })
  }

  /** The problems of exactly one value. */
  function problemsAt(path: Path): Found[] {
    const pointer = toPointer(path)
    return problems.value.filter((one) => one.pointer === pointer || one.pointer?.startsWith(`${pointer}/`) === true)
  }

  function lock(on: boolean): void {
    locked.value = on
    view.dispatch({ effects: writable.reconfigure(readOnly(on)) })
  }

  let gone = false
  async function addAssist(): Promise<void> {
    const { assist } = await import('./assist')
    if (!gone) view.dispatch({ effects: StateEffect.appendConfig.of(assist(() => good.value, contracts)) })
  }

  onScopeDispose(() => {
    gone = true
    clearTimeout(timer)
    view.destroy()
  })
  void addAssist()
  parse()
  checking.soon(first, 0)

  return {
    name, view, text, good, broken, blank, rows, index, selected, selectedPath, caret, depths, locked, problems, checking, contracts,
    edit, select, goTo, goToLine, mend, replaceAll, problemsOf, problemsAt, lock,
    valueAt: (path: Path) => valueAt(good.value?.data, path),
    undo: () => undo(view), redo: () => redo(view), samePath,
  }
}

export type Editing = ReturnType<typeof useEditing>
