// The protocols of the bench: listed, created, deleted and restored.
import { computed, onScopeDispose, ref, shallowRef } from 'vue'
import { api, read } from '../../api/client'
import { sentenceOf } from '../../api/refused'
import type { Sent, Received } from '../../api/types'
import { writeScalar } from '../text/write'

/** The server checks the remaining ones gradually. */
const AGAIN_MS = 1_500
const MOST_LOOKS = 40
const LONGEST_NAME = 80

export type Summary = Received<'ProtocolSummary'>
export type Thrown = Received<'Thrown'>

export function useLibrary() {
  const protocols = shallowRef<readonly Summary[] | null>(null)
  const trash = shallowRef<readonly Thrown[]>([])
  const refused = ref('')
  const unlisted = ref('')
  /** What was refused stays until the next attempt: the list is read again meanwhile. */
  const failure = computed({ get: () => refused.value || unlisted.value, set: (words) => (refused.value = words) })
  let timer: ReturnType<typeof setTimeout> | undefined
  let looks = 0

  async function attempt<T>(ask: () => Promise<T>, said = refused): Promise<T | null> {
    try {
      const told = await ask()
      said.value = ''
      return told
    } catch (refusal) {
      said.value = sentenceOf(refusal)
      return null
    }
  }

  async function load(): Promise<void> {
    await attempt(async () => {
      const [all, thrown] = await Promise.all([read(api.GET('/api/v1/protocols')), read(api.GET('/api/v1/trash'))])
      protocols.value = all as unknown as readonly Summary[]
      trash.value = thrown as unknown as readonly Thrown[]
    }, unlisted)
    clearTimeout(timer)
    // A list that could not be had is asked for again, too: a server that was busy is there a moment later.
    const waiting = unlisted.value !== '' || protocols.value?.some((one) => one.errors === null) === true
    if (waiting && looks++ < MOST_LOOKS) timer = setTimeout(() => void load(), AGAIN_MS)
  }
  onScopeDispose(() => clearTimeout(timer))

  /** The name of the new file; null if it was refused. */
  async function make(body: Sent<'NewProtocol'>): Promise<string | null> {
    const told = await attempt(() => read(api.POST('/api/v1/protocols', { body })))
    return told?.name ?? null
  }

  async function throwAway(name: string): Promise<void> {
    await attempt(() => read(api.DELETE('/api/v1/protocols/{name}', { params: { path: { name } } })))
    await load()
  }

  async function restore(id: string): Promise<void> {
    await attempt(() => read(api.POST('/api/v1/trash/{id}/restore', { params: { path: { id } } })))
    await load()
  }

  return { protocols, trash, failure, load, make, throwAway, restore }
}

export type Library = ReturnType<typeof useLibrary>

/** Whether every word occurs somewhere in the summary of a protocol. */
export function found(all: readonly Summary[], words: string): Summary[] {
  const wanted = words.toLowerCase().split(/\s+/).filter(Boolean)
  return all.filter((one) => {
    const text = [one.name, one.title, one.summary, ...Object.keys(one.roles), ...Object.values(one.roles)].join(' ').toLowerCase()
    return wanted.every((word) => text.includes(word))
  })
}

/** `grid-scan.yaml` from what a person typed: runs and their folders have this name, so that accents and the letters of other scripts are left out. */
export function fileName(typed: string): string {
  const [stem = '', suffix] = typed.trim().split(/\.(ya?ml|json)$/i)
  const name = suffix === undefined ? stem.replace(/\s+/g, '_') : stem
  const plain = name.normalize('NFKD').replace(/[^\w ./-]/g, '').replace(/(^|\/)[^A-Za-z0-9/]+/g, '$1').slice(0, LONGEST_NAME)
  return `${plain.replace(/[\s./]+$/, '') || 'protocol'}.${suffix ?? 'yaml'}`
}

/** A protocol with no step yet; `summary` is what the name cannot say. */
export function emptyProtocol(file: string, name: string, summary = ''): string {
  const data = { labrun: 1, name, ...(summary === '' ? {} : { summary }), steps: [] }
  if (file.toLowerCase().endsWith('.json')) return `${JSON.stringify(data, null, 2)}\n`
  const written = (text: string): string => writeScalar(text, { flow: false, json: false })
  return `labrun: 1\nname: ${written(name)}\n${summary === '' ? '' : `summary: ${written(summary)}\n`}steps: []\n`
}

/** A name that is not in use yet. */
export function freeName(wanted: string, taken: ReadonlySet<string>): string {
  const stem = wanted.replace(/\.(ya?ml|json)$/i, '')
  const suffix = wanted.slice(stem.length) || '.yaml'
  let number = 2
  let name = `${stem}${suffix}`
  while (taken.has(name)) name = `${stem}_${String(number++)}${suffix}`
  return name
}
