// The state of a command: sent, answered or refused; the button shows which, and never too early.
import { ref } from 'vue'
import { sentenceOf } from '../api/refused'
import { useInControl } from './inControl'

/** `said` is what was answered; `failed` why not. One at a time; `free` ones need no control. */
export function useCommand() {
  const inControl = useInControl()
  const sending = ref('')
  const said = ref('')
  const failed = ref('')

  /** Send it; true if it was done. */
  async function send(name: string, ask: () => Promise<{ readonly text?: string } | undefined>, free = false): Promise<boolean> {
    if (sending.value) return false
    sending.value = name
    said.value = failed.value = ''
    try {
      if (!free) await inControl.ensure()
      said.value = (await ask())?.text ?? ''
      return true
    } catch (fault) {
      failed.value = sentenceOf(fault)
      return false
    } finally {
      sending.value = ''
    }
  }
  return { sending, said, failed, send }
}
