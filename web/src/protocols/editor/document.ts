// A protocol's file: loaded with its revision, saved against it, kept as a draft meanwhile.
import { computed, onScopeDispose, ref, shallowRef } from 'vue'
import { api, read } from '../../api/client'
import { Refused, sentenceOf } from '../../api/refused'
import { withoutBreaks, type Breaks } from './breaks'

const DRAFT_MS = 2_000

export interface Draft {
  base: string
  text: string
  at: string
}

/** Someone saved meanwhile: the three texts, with the editor's line breaks. */
export interface Conflict {
  base: string | null
  mine: string
  theirs: string
  theirsRevision: string
}

/** What somebody else has saved since; null for a file that is gone. */
export interface Newer {
  file: { text: string; revision: string; modified: string } | null
}

function keyOf(name: string): string {
  return `labrun.draft:${name}`
}

export function useDocument(name: string) {
  const saved = ref('')
  const revision = ref('')
  const modified = ref('')
  const draft = shallowRef<Draft | null>(null)
  const conflict = shallowRef<Conflict | null>(null)
  const newer = shallowRef<Newer | null>(null)
  const saving = ref(false)
  const failure = ref('')
  const text = ref('')
  const dirty = computed(() => text.value !== saved.value)
  let breaks: Breaks = withoutBreaks('')
  let timer: ReturnType<typeof setInterval> | undefined

  /** The initial text; throws the server's refusal. */
  async function open(): Promise<string> {
    const told = await read(api.GET('/api/v1/protocols/{name}', { params: { path: { name } } }))
    breaks = withoutBreaks(told.text)
    saved.value = text.value = breaks.text
    revision.value = told.revision
    modified.value = told.modified
    draft.value = keptDraft(name)
    if (draft.value?.text === saved.value) forget()
    // Before anybody can write: what was saved meanwhile would be replaced, unseen.
    if (draft.value && draft.value.base !== told.revision) disagree({ base: await earlier(draft.value.base), mine: draft.value.text, theirs: saved.value, theirsRevision: told.revision })
    timer = setInterval(keep, DRAFT_MS)
    return saved.value
  }

  /** An earlier version, null if there is none. */
  function earlier(version: string): Promise<string | null> {
    return read(api.GET('/api/v1/protocols/{name}/versions/{revision}', { params: { path: { name, revision: version } } })).then((told) => withoutBreaks(told.text).text, () => null)
  }

  function keep(): void {
    if (!dirty.value || conflict.value) return
    const now: Draft = { base: revision.value, text: text.value, at: new Date().toISOString() }
    try {
      localStorage.setItem(keyOf(name), JSON.stringify(now))
    } catch {
      failure.value = 'this browser has no space for a draft: save the protocol'
    }
  }

  function forget(): void {
    localStorage.removeItem(keyOf(name))
    draft.value = null
  }

  /** True if it is saved; on a conflict the three texts are in `conflict`. */
  async function save(over = revision.value): Promise<boolean> {
    if (saving.value) return false
    saving.value = true
    failure.value = ''
    const mine = text.value
    try {
      const body = { text: breaks.restore(mine), base: over }
      const told = await read(api.PUT('/api/v1/protocols/{name}', { params: { path: { name } }, body }))
      taken(mine, told.revision, told.modified)
      return true
    } catch (refusal) {
      if (refusal instanceof Refused && refusal.status === 409) conflict.value = conflictOf(refusal, mine)
      if (!conflict.value) failure.value = sentenceOf(refusal)
      return false
    } finally {
      saving.value = false
    }
  }

  /** Look whether the file has changed since it was read; a server that does not answer says nothing. */
  async function look(): Promise<void> {
    const known = revision.value
    const told = await read(api.GET('/api/v1/protocols/{name}', { params: { path: { name } } })).catch((refusal: unknown) => (refusal instanceof Refused && refusal.status === 404 ? null : undefined))
    if (told === undefined || saving.value || known !== revision.value) return
    if (told?.revision === known) newer.value = null
    else if (newer.value === null || told?.revision !== newer.value.file?.revision) newer.value = { file: told }
  }

  /** Show their text instead, which is to be written; a conflict if there are changes here. */
  function takeNewer(): string | null {
    const theirs = newer.value?.file
    if (!theirs) return null
    const now = withoutBreaks(theirs.text)
    if (dirty.value) {
      disagree({ base: saved.value, mine: text.value, theirs: now.text, theirsRevision: theirs.revision })
      return null
    }
    breaks = now
    taken(now.text, theirs.revision, theirs.modified)
    return now.text
  }

  function taken(now: string, revisionNow: string, at: string): void {
    newer.value = null
    saved.value = now
    revision.value = revisionNow
    modified.value = at
    conflict.value = null
    forget()
  }

  /** The conflict is resolved: the next save replaces the other's text. */
  function settle(): void {
    if (!conflict.value) return
    newer.value = null
    revision.value = conflict.value.theirsRevision
    saved.value = conflict.value.theirs
    conflict.value = null
    forget()
  }

  onScopeDispose(() => {
    clearInterval(timer)
    keep()
  })

  /** The editor's current text. */
  function write(now: string): void {
    text.value = now
  }

  function disagree(now: Conflict): void {
    conflict.value = now
  }

  return { saved, revision, modified, draft, conflict, newer, saving, failure, text, dirty, open, look, takeNewer, save, keep, forget, settle, write }
}

export type Document = ReturnType<typeof useDocument>

function keptDraft(name: string): Draft | null {
  try {
    return JSON.parse(localStorage.getItem(keyOf(name)) ?? 'null') as Draft | null
  } catch {
    return null
  }
}

function conflictOf(refusal: Refused, mine: string): Conflict | null {
  const told = refusal.fault as unknown as { theirs?: unknown; theirs_revision?: unknown; base?: unknown }
  if (typeof told.theirs !== 'string' || typeof told.theirs_revision !== 'string') return null
  const base = typeof told.base === 'string' ? withoutBreaks(told.base).text : null
  return { base, mine, theirs: withoutBreaks(told.theirs).text, theirsRevision: told.theirs_revision }
}
