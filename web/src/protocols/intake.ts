// Steps from elsewhere: done by hand on a device or recorded, to insert into a protocol.
import { defineStore } from 'pinia'
import { computed, ref, watch } from 'vue'

const KEY = 'labrun.intake'

export interface Came {
  /** YAML of one step, as the server sends it for a goal. */
  step: string
  device: string
  contract: string
}

interface Kept {
  steps: Came[]
  target: string | null
  after: string
  place: string
}

function kept(): Kept {
  try {
    return { steps: [], target: null, after: '', place: '', ...(JSON.parse(sessionStorage.getItem(KEY) ?? '{}') as Partial<Kept>) }
  } catch {
    return { steps: [], target: null, after: '', place: '' }
  }
}

/** `target` is the protocol that was opened last; its editor takes the steps when it is shown. */
export const useIntake = defineStore('intake', () => {
  const first = kept()
  const steps = ref<Came[]>(first.steps)
  const target = ref<string | null>(first.target)
  /** The title of the row after which they go. */
  const after = ref(first.after)
  /** That row's pointer. */
  const place = ref(first.place)
  const recording = ref(false)
  const count = computed(() => steps.value.length)
  watch([steps, target, after, place], () => {
    sessionStorage.setItem(KEY, JSON.stringify({ steps: steps.value, target: target.value, after: after.value, place: place.value }))
  }, { deep: true })

  function add(came: Came): string {
    steps.value = [...steps.value, came]
    if (target.value === null) return 'kept for a new protocol: Protocols, New protocol, Recorded'
    return `kept: will go ${after.value ? `after “${after.value}” ` : ''}into ${target.value} when you open it`
  }

  /** Take all of them, leaving none. */
  function take(): Came[] {
    const all = steps.value
    steps.value = []
    return all
  }

  function opened(name: string | null, row = '', pointer = ''): void {
    target.value = name
    after.value = row
    place.value = pointer
  }

  function clear(): void {
    steps.value = []
  }

  return { steps, target, after, place, recording, count, add, take, opened, clear }
})
