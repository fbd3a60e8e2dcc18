// Play the protocol through with simulated devices: a long scan takes minutes, and can be stopped.
import { onScopeDispose, ref, shallowRef, watch } from 'vue'
import { api } from '../../api/client'
import type { Received } from '../../api/types'
import type { Editing } from './editing'

const LONGEST_S = 300

export function useRehearsing(editing: Editing) {
  const rehearsed = shallowRef<Received<'Rehearsed'> | null>(null)
  const rehearsing = ref(false)
  const seconds = ref(0)
  const refusal = ref('')
  let stop: AbortController | null = null

  async function rehearse(): Promise<void> {
    const ending = new AbortController()
    stop = ending
    rehearsing.value = true
    seconds.value = 0
    refusal.value = ''
    const ticking = setInterval(() => {
      seconds.value++
      if (seconds.value >= LONGEST_S) ending.abort()
    }, 1_000)
    try {
      const body = { text: editing.text.value, name: editing.name }
      const { data, error } = await api.POST('/api/v1/rehearse', { body, signal: ending.signal })
      if (data) rehearsed.value = data as unknown as Received<'Rehearsed'>
      else refusal.value = messageOf(error)
    } catch {
      refusal.value = seconds.value >= LONGEST_S ? 'the rehearsal took longer than five minutes' : ending.signal.aborted ? '' : 'the server did not answer'
    } finally {
      clearInterval(ticking)
      rehearsing.value = false
    }
  }

  function cancel(): void {
    stop?.abort()
  }

  watch(editing.text, () => (rehearsed.value = null))
  onScopeDispose(cancel)
  return { rehearsed, rehearsing, seconds, refusal, rehearse, cancel }
}

function messageOf(error: unknown): string {
  const told = error as { message?: unknown; hint?: unknown } | undefined
  const words = [told?.message, told?.hint].filter((one) => typeof one === 'string' && one !== '')
  return words.length > 0 ? words.join('. ') : 'the rehearsal was refused'
}
