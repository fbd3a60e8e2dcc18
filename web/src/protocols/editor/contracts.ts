// The capabilities of this bench's devices, for titles, forms, completion and "Add step".
import { defineStore } from 'pinia'
import { computed, shallowRef } from 'vue'
import { api, read } from '../../api/client'
import { useConnection } from '../../api/updates/connection'
import type { ActionForm, DeviceDetail, DeviceState, Received } from '../../api/types'
import { isMap, valueAt } from '../text/path'

export type Schema = Record<string, unknown>

export const useContracts = defineStore('contracts', () => {
  const devices = shallowRef<readonly DeviceDetail[]>([])
  const schema = shallowRef<Schema>({})
  /** The CSV files beside the protocol that is open. */
  const tables = shallowRef<readonly Received<'CsvTable'>[]>([])
  const connection = useConnection()
  let asked: Promise<void> | null = null

  /** Load once; again if nothing came. */
  function load(): Promise<void> {
    asked ??= fetchAll().catch(() => {
      asked = null
    })
    return asked
  }

  async function fetchAll(): Promise<void> {
    const [all, lab] = await Promise.all([read(api.GET('/api/v1/devices')), read(api.GET('/api/v1/schema'))])
    schema.value = lab
    const names = (all as unknown as readonly DeviceState[]).map((one) => one.name)
    const details = names.map((device) => read(api.GET('/api/v1/devices/{device}', { params: { path: { device } } })))
    devices.value = (await Promise.all(details)) as unknown as DeviceDetail[]
  }

  async function loadTables(protocol: string): Promise<void> {
    tables.value = (await read(api.GET('/api/v1/tables', { params: { query: { protocol } } }))) as unknown as Received<'CsvTable'>[]
  }

  /** A device of a contract: of that name if there is one. */
  function deviceOf(contract: string, name: string): DeviceDetail | null {
    const fit = devices.value.filter((one) => one.contract === contract)
    return fit.find((one) => one.name === name) ?? fit[0] ?? null
  }

  const reach = computed(() => new Map(Object.entries(connection.bench.devices).map(([name, one]) => [name, one.reach])))

  return { devices, schema, tables, load, loadTables, deviceOf, reach }
})

export type Contracts = ReturnType<typeof useContracts>

/** The action that `role.action` of a protocol is; null if unknown. */
export function actionOf(contracts: Contracts, data: unknown, words: unknown): { device: DeviceDetail; action: ActionForm } | null {
  if (typeof words !== 'string') return null
  const [role = '', name = ''] = words.split('.')
  const contract = valueAt(data, ['devices', role])
  const device = typeof contract === 'string' ? contracts.deviceOf(contract, role) : null
  const action = device?.actions.find((one) => one.name === name)
  return device && action ? { device, action } : null
}

/** The language's schema for a key of this kind of step. */
export function keyText(schema: Schema, kind: string, key: string): string {
  const found = resolve(schema, valueAt(schema, ['$defs', `step-${kind}`, 'properties', key]))
  return isMap(found) && typeof found['description'] === 'string' ? found['description'] : ''
}

/** Follow `$ref`s within the schema. */
export function resolve(schema: Schema, part: unknown): unknown {
  let here = part
  for (let i = 0; i < 8 && isMap(here) && typeof here['$ref'] === 'string'; i++) here = valueAt(schema, here['$ref'].slice(2).split('/'))
  return here
}
