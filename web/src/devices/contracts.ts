// The contracts of the bench's devices: each loaded once, because they do not change while a server runs.
import { defineStore } from 'pinia'
import { reactive, ref } from 'vue'
import { api, read } from '../api/client'
import { sentenceOf } from '../api/refused'
import type { DeviceDetail } from '../api/types'

export const useContracts = defineStore('forms', () => {
  const details = reactive<Record<string, DeviceDetail>>({})
  const failed = ref('')

  /** Load one; the old one stays until the answer arrives. */
  async function load(device: string): Promise<void> {
    try {
      const asked = api.GET('/api/v1/devices/{device}', { params: { path: { device } } })
      // The client's types forget that a range has two ends.
      details[device] = (await read(asked)) as unknown as DeviceDetail
      failed.value = ''
    } catch (failure) {
      failed.value = sentenceOf(failure)
    }
  }

  return { details, failed, load }
})
