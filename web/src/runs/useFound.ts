// The runs for which a search holds: asked of the server's index, with the live state of those that change.
import { computed, onScopeDispose, shallowRef, watch, type Ref } from 'vue'
import { api, read } from '../api/client'
import { sentenceOf } from '../api/refused'
import type { FoundRun, RunSummary } from '../api/types'
import { useConnection } from '../api/updates/connection'
import { sortedRuns } from './sortedRuns'

const REST_MS = 250
export const STEP = 200

export type Found = RunSummary & Partial<Pick<FoundRun, 'samples' | 'tags' | 'note'>>

export function useFound(find: Ref<string>) {
  const connection = useConnection()
  const told = shallowRef<{ runs: readonly unknown[]; total: number; all: number; numbers: readonly string[] } | null>(null)
  const failure = shallowRef('')
  const shown = shallowRef(STEP)
  let timer: ReturnType<typeof setTimeout> | undefined
  let asked = 0

  async function ask(): Promise<void> {
    const mine = ++asked
    try {
      const found = await read(api.GET('/api/v1/found', { params: { query: { find: find.value.trim(), limit: shown.value } } }))
      if (mine !== asked) return
      told.value = found
      failure.value = ''
    } catch (fault) {
      if (mine === asked) failure.value = sentenceOf(fault)
    }
  }
  /** What the list depends on: a run that begins, or ends, or is gone. */
  const course = computed(() => Object.values(connection.bench.runs).map((run) => `${run.id} ${run.fate}`).join())
  watch([find, course, shown], ([text], [before]) => {
    clearTimeout(timer)
    if (text !== before) shown.value = STEP
    timer = setTimeout(() => void ask(), REST_MS)
  })
  onScopeDispose(() => clearTimeout(timer))
  void ask()

  const runs = computed<Found[]>(() => {
    if (failure.value && find.value.trim()) return [] // what was found before is not what is sought now
    const live = connection.bench.runs
    const found = (told.value?.runs ?? []).map((run) => ({ ...(run as Found), ...live[(run as Found).id] }))
    if (find.value.trim()) return sortedRuns(found)
    const known = new Set(found.map((run) => run.id))
    return sortedRuns([...found, ...Object.values(live).filter((run) => !known.has(run.id))])
  })
  const all = computed(() => Math.max(told.value?.all ?? 0, Object.keys(connection.bench.runs).length))
  const total = computed(() => told.value?.total ?? 0)
  const numbers = computed(() => told.value?.numbers ?? [])
  return { told, runs, all, total, numbers, failure, shown, ready: computed(() => told.value !== null), again: ask }
}
