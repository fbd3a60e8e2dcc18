// Ask the server's checker while the user types; answers for an older text are discarded.
import { onScopeDispose, ref, shallowRef, watch } from 'vue'
import { api, read } from '../../api/client'
import { sentenceOf } from '../../api/refused'
import type { Received } from '../../api/types'
import type { Reading } from '../text/reading'
import { brokenAt, foundIn, type Found } from './problems'

const CHECK_MS = 400
const AGAIN_MS = 5_000

export type Checked = Received<'CheckedText'>

export function useChecking(name: string) {
  const problems = shallowRef<readonly Found[]>([])
  const checked = shallowRef<Checked | null>(null)
  const checkedText = shallowRef<string | null>(null)
  /** Why there is no answer. */
  const silent = ref('')
  const asking = ref(false)
  let timer: ReturnType<typeof setTimeout> | undefined
  let wanted = ''

  function soon(text: string, ms = CHECK_MS): void {
    wanted = text
    clearTimeout(timer)
    timer = setTimeout(() => void check(), ms)
  }

  async function check(): Promise<void> {
    const text = wanted
    asking.value = true
    try {
      const told = await read(api.POST('/api/v1/check', { body: { text, name } }))
      if (text !== wanted) return
      checked.value = told as unknown as Checked
      checkedText.value = text
      problems.value = foundIn(text, told.problems as Checked['problems'], name)
      silent.value = ''
    } catch (failure) {
      silent.value = sentenceOf(failure)
      if (text === wanted) timer = setTimeout(() => void check(), AGAIN_MS)
    } finally {
      asking.value = false
    }
  }

  /** What the page knows before the checker has answered: that the text is not YAML. */
  function local(reading: Reading): void {
    const others = problems.value.filter((one) => one.code !== 'YAML')
    if (!reading.ok) problems.value = [brokenAt(reading), ...others.filter((one) => !one.code.startsWith('E10'))]
    else if (others.length !== problems.value.length) problems.value = others
  }

  function moved(by: (all: readonly Found[]) => Found[]): void {
    problems.value = by(problems.value)
  }

  /** Until the checker has answered, at most five seconds. */
  function first(): Promise<void> {
    if (checked.value) return Promise.resolve()
    return new Promise((resolve) => {
      const late = setTimeout(done, AGAIN_MS)
      const stop = watch(checked, done)
      function done(): void {
        clearTimeout(late)
        stop()
        resolve()
      }
    })
  }

  onScopeDispose(() => clearTimeout(timer))
  return { problems, checked, checkedText, silent, asking, soon, local, moved, first }
}
