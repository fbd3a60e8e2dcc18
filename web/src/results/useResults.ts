// The results of a run: its maps, the spectra of its points, and the run itself.
import { computed, shallowRef, watch } from 'vue'
import { api, read } from '../api/client'
import { useConnection } from '../api/updates/connection'
import { sentenceOf } from '../api/refused'
import type { RunDetail, Received } from '../api/types'
import { loadPoints } from '../runs/state/loadPoints'
import { RunPicture } from '../runs/picture'
import { decodeFloat32 } from './float32'
import { binary } from './spectra'

export type MapHead = Received<'MapHead'>
export type SpectrumHead = Received<'SpectrumHead'>

/** The name of a map: table and column. */
export const mapName = (head: MapHead): string => `${head.table}/${head.column}`

export function useResults(run: () => string) {
  const connection = useConnection()
  const picture = shallowRef<RunPicture | null>(null)
  const heads = shallowRef<readonly MapHead[]>([])
  const cellKeys = shallowRef<Received<'Maps'>['cell_keys']>({})
  const spectra = shallowRef<readonly SpectrumHead[]>([])
  const failure = shallowRef('')
  const loading = shallowRef(true)
  let cells = new Map<string, Promise<Float32Array>>()
  let asked = 0

  /** The spectrum of each point; of one without a point, by its file. */
  const byKey = computed(() => {
    const found = new Map<string, SpectrumHead>()
    for (const head of spectra.value) if (!found.has(head.key ?? head.file)) found.set(head.key ?? head.file, head)
    return found
  })

  async function load(): Promise<void> {
    const mine = ++asked
    loading.value = true
    failure.value = ''
    const path = { params: { path: { id: run() } } }
    try {
      const [detail, maps, list] = await Promise.all([
        read(api.GET('/api/v1/runs/{id}', path)), read(api.GET('/api/v1/runs/{id}/maps', path)),
        read(api.GET('/api/v1/runs/{id}/spectra', path)),
      ])
      // openapi-fetch makes arrays of tuples; the description has tuples.
      const made = new RunPicture(detail as unknown as RunDetail)
      await loadPoints(made)
      if (mine !== asked) return
      cells = new Map()
      picture.value = made
      heads.value = maps.maps
      cellKeys.value = maps.cell_keys
      spectra.value = list.spectra
    } catch (fault) {
      if (mine === asked) failure.value = sentenceOf(fault)
    } finally {
      if (mine === asked) loading.value = false
    }
  }

  /** The values of a map, row by row from the lowest y; loaded once. */
  function values(head: MapHead): Promise<Float32Array> {
    const name = mapName(head)
    const known = cells.get(name)
    if (known) return known
    const path = { id: run(), table: head.table, column: head.column }
    const made = binary(api.GET('/api/v1/runs/{id}/maps/{table}/{column}', { params: { path }, parseAs: 'arrayBuffer' }))
      .then(({ bytes }) => decodeFloat32(bytes, head.width * head.height))
    cells.set(name, made)
    made.catch(() => cells.delete(name))
    return made
  }

  watch(run, () => void load(), { immediate: true })
  // New measurements are shown when the run is over.
  watch(() => connection.bench.runs[run()]?.live, (now, before) => {
    if (before === true && now === false) void load()
  })
  return { picture, heads, cellKeys, spectra, byKey, failure, loading, load, values }
}
