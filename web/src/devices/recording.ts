// While Record is on, what succeeds by hand becomes a step: also an action that ends long after its click.
import { defineStore } from 'pinia'
import { reactive, watch } from 'vue'
import { useLive } from '../api/push/live'
import type { GoalState } from '../api/types'
import { useIntake } from '../protocols/intake'

export const useRecording = defineStore('recording', () => {
  const live = useLive()
  const intake = useIntake()
  const under_way = reactive(new Set<string>())

  /** Called with the answer to each click. */
  function follow(goal: GoalState): void {
    if (!intake.recording) return
    if (goal.ended_at === null) under_way.add(goal.id)
    else if (goal.state === 'SUCCEEDED') add(goal)
  }
  watch(() => [...under_way].map((id) => live.bench.goals[id]), (goals) => {
    for (const goal of goals) {
      if (goal?.ended_at == null) continue
      under_way.delete(goal.id)
      if (goal.state === 'SUCCEEDED') add(goal)
    }
  })

  /** Give an action to the protocol that is open, or to a new one; a sentence that says which. */
  function add(goal: GoalState): string {
    const contract = live.bench.devices[goal.device]?.contract ?? ''
    return intake.add({ step: goal.step, device: goal.device, contract })
  }

  return { follow, add }
})
