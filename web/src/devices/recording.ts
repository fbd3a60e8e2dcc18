// While Record is on, each manual action that succeeds becomes a step, even if it ends long after its click.
import { defineStore } from 'pinia'
import { reactive, watch } from 'vue'
import { useConnection } from '../api/updates/connection'
import type { GoalState } from '../api/types'
import { useIntake } from '../protocols/intake'

export const useRecording = defineStore('recording', () => {
  const connection = useConnection()
  const intake = useIntake()
  const under_way = reactive(new Set<string>())

  /** Called with the answer to each click. */
  function follow(goal: GoalState): void {
    if (!intake.recording) return
    if (goal.ended_at === null) under_way.add(goal.id)
    else if (goal.state === 'SUCCEEDED') add(goal)
  }
  watch(() => [...under_way].map((id) => connection.bench.goals[id]), (goals) => {
    for (const goal of goals) {
      if (goal?.ended_at == null) continue
      under_way.delete(goal.id)
      if (goal.state === 'SUCCEEDED') add(goal)
    }
  })

  /** Add an action to the open protocol or to a new one; returns a sentence that says which. */
  function add(goal: GoalState): string {
    const contract = connection.bench.devices[goal.device]?.contract ?? ''
    return intake.add({ step: goal.step, device: goal.device, contract })
  }

  return { follow, add }
})
