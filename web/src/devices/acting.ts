// One manual action, from the click to the device's final answer.
import { computed, ref, type ComputedRef, type Ref } from 'vue'
import { api, command } from '../api/client'
import { useConnection } from '../api/updates/connection'
import { Refused, sentenceOf } from '../api/refused'
import type { GoalState } from '../api/types'
import { useRecording } from './recording'

export interface Acting {
  /** The goal as the device reports it; null before the first action. */
  goal: ComputedRef<GoalState | null>
  /** True from the click until the server has answered. */
  sending: Ref<boolean>
  /** Why it was refused. */
  refused: Ref<string>
  /** The same by parameter. */
  faults: Ref<Record<string, string>>
  run(params: Record<string, unknown>, armed?: string): Promise<GoalState | null>
  cancel(): Promise<void>
}

/** The button shows that it was sent; only the device reports what it did. */
export function useAction(device: () => string, action: () => string): Acting {
  const connection = useConnection()
  const recording = useRecording()
  const last = ref<GoalState | null>(null)
  const sending = ref(false)
  const refused = ref('')
  const faults = ref<Record<string, string>>({})
  const goal = computed(() => {
    if (last.value === null) return null
    const told = connection.bench.goals[last.value.id]
    return told !== undefined && last.value.ended_at === null ? told : last.value
  })

  async function run(params: Record<string, unknown>, armed?: string): Promise<GoalState | null> {
    if (sending.value) return null
    sending.value = true
    refused.value = ''
    faults.value = {}
    try {
      const path = { device: device(), action: action() }
      const body = { params, armed: armed ?? null }
      const told = await command(() =>
        api.POST('/api/v1/devices/{device}/actions/{action}', { params: { path }, body }),
      )
      last.value = told
      recording.follow(told)
      return told
    } catch (failure) {
      refused.value = sentenceOf(failure)
      if (failure instanceof Refused) faults.value = (failure.fault.details['params'] ?? {}) as Record<string, string>
      return null
    } finally {
      sending.value = false
    }
  }

  async function cancel(): Promise<void> {
    if (goal.value === null) return
    const path = { id: goal.value.id }
    try {
      await command(() => api.POST('/api/v1/goals/{id}/cancel', { params: { path } }))
    } catch (failure) {
      refused.value = sentenceOf(failure)
    }
  }

  return { goal, sending, refused, faults, run, cancel }
}
