// The values that a run has collected so far, by point; refreshed while it is live.
import { onBeforeUnmount, shallowRef, watch, type Ref } from 'vue'
import { api, read } from '../../api/client'
import type { Received } from '../../api/types'
import { decodeFloat32 } from '../../results/float32'
import { binary } from '../../results/spectra'

export type MapHead = Received<'MapHead'>

export interface MapValues {
  head: MapHead
  /** Point key → value. */
  byKey: ReadonlyMap<string, number>
  cells: Float32Array
}

const AGAIN_MS = 2500

export function useMapValues(run: () => string, live: () => boolean, column: Ref<string>) {
  const heads = shallowRef<readonly MapHead[]>([])
  const values = shallowRef<MapValues | null>(null)
  let keys: Readonly<Record<string, readonly (string | null)[]>> = {}
  let timer: ReturnType<typeof setTimeout> | undefined
  let asked = 0

  async function ask(): Promise<void> {
    clearTimeout(timer)
    const mine = ++asked
    try {
      const told = await read(api.GET('/api/v1/runs/{id}/maps', { params: { path: { id: run() } } }))
      if (mine !== asked) return
      heads.value = told.maps
      keys = told.cell_keys
      await fetchColumn(mine)
    } catch {
      // No table yet, or no connection: keep what is drawn and try again.
    } finally {
      if (mine === asked && live()) timer = setTimeout(() => void ask(), AGAIN_MS)
    }
  }

  async function fetchColumn(mine: number): Promise<void> {
    const head = heads.value.find((one) => `${one.table}/${one.column}` === column.value)
    if (!head) {
      values.value = null
      return
    }
    const path = { id: run(), table: head.table, column: head.column }
    const { bytes } = await binary(api.GET('/api/v1/runs/{id}/maps/{table}/{column}', { params: { path }, parseAs: 'arrayBuffer' }))
    if (mine !== asked) return
    const cells = decodeFloat32(bytes)
    const byKey = new Map<string, number>()
    keys[head.table]?.forEach((key, i) => {
      const value = cells[i]
      if (key !== null && value !== undefined && !Number.isNaN(value)) byKey.set(key, value)
    })
    values.value = { head, byKey, cells }
  }

  watch([run, column, live], () => void ask(), { immediate: true })
  onBeforeUnmount(() => {
    asked++
    clearTimeout(timer)
  })
  return { heads, values }
}
