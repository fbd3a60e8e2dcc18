// Actions by hand that become steps of a protocol: recorded as they succeed, or added one by one.
import { defineStore } from 'pinia'
import { ref, watch } from 'vue'
import { useLive } from '../api/push/live'
import type { GoalState } from '../api/types'

const KEY = 'labrun.recorded'

export interface RecordedStep {
  id: string
  device: string
  contract: string
  /** `{do: gantry.move_to, with: {x: 10.5}}`, as the server writes it. */
  step: string
}

/** The steps wait here, over pages and reloads, until a protocol takes them. */
export const useRecorded = defineStore('recorded', () => {
  const live = useLive()
  const steps = ref<RecordedStep[]>(kept())
  const recording = ref(false)
  const followed = new Set<string>()
  watch(steps, (now) => sessionStorage.setItem(KEY, JSON.stringify(now)), { deep: true })

  /** While recording, an action becomes a step once it has succeeded. */
  function follow(goal: GoalState): void {
    if (!recording.value) return
    if (goal.ended_at === null) followed.add(goal.id)
    else if (goal.state === 'SUCCEEDED') add(goal)
  }
  watch(() => live.bench.goals, (goals) => {
    for (const id of followed) {
      const goal = goals[id]
      if (goal?.ended_at == null) continue
      followed.delete(id)
      if (goal.state === 'SUCCEEDED') add(goal)
    }
  }, { deep: 1 })

  function add(goal: GoalState): void {
    if (steps.value.some((one) => one.id === goal.id)) return
    const contract = live.bench.devices[goal.device]?.contract ?? ''
    steps.value = [...steps.value, { id: goal.id, device: goal.device, contract, step: goal.step }]
  }

  function remove(id: string): void {
    steps.value = steps.value.filter((one) => one.id !== id)
  }

  /** Give the steps to a protocol; they wait here no longer. */
  function take(): RecordedStep[] {
    const taken = steps.value
    steps.value = []
    recording.value = false
    return taken
  }

  return { steps, recording, follow, add, remove, take }
})

function kept(): RecordedStep[] {
  return JSON.parse(sessionStorage.getItem(KEY) ?? '[]') as RecordedStep[]
}
