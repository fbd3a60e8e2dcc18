// What the protocol would do on this bench, requested again when a changed text passes the checker.
import { computed, onScopeDispose, ref, shallowRef, watch } from 'vue'
import { api, read } from '../../api/client'
import { sentenceOf } from '../../api/refused'
import type { Received } from '../../api/types'
import type { Editing } from './editing'

const CALM_MS = 700

export type Preview = Received<'Preview'>

export function usePreviewing(editing: Editing) {
  const told = shallowRef<Preview | null>(null)
  const toldText = ref('')
  const failure = ref('')
  const asking = ref(false)
  /** The next drag over the picture draws the area. */
  const drawing = ref(false)
  let timer: ReturnType<typeof setTimeout> | undefined

  async function ask(): Promise<void> {
    const text = editing.text.value
    if (text === toldText.value || asking.value) return
    if (editing.blank.value) return void (told.value = null)
    asking.value = true
    try {
      told.value = (await read(api.POST('/api/v1/preview', { body: { text, name: editing.name } }))) as unknown as Preview
      failure.value = ''
    } catch (refusal) {
      failure.value = sentenceOf(refusal)
    } finally {
      toldText.value = text
      asking.value = false
    }
    if (editing.text.value !== text) soon()
  }

  function soon(): void {
    clearTimeout(timer)
    timer = setTimeout(() => void ask(), CALM_MS)
  }

  watch(editing.checking.checkedText, soon)
  onScopeDispose(() => clearTimeout(timer))

  const stale = computed(() => editing.text.value !== toldText.value)
  /** Id of a loop -> what it runs over: "a grid of 21 x 51 = 1,071 points (snake)". */
  const loops = computed(() => {
    const found = new Map<string, string>()
    for (const track of told.value?.tracks ?? []) {
      for (const words of track.tracks) {
        const at = words.indexOf(': ')
        if (at > 0) found.set(words.slice(0, at).split('/').at(-1) ?? '', words.slice(at + 2).replaceAll(' x ', ' × '))
      }
    }
    return found
  })
  return { told, failure, asking, drawing, stale, loops, ask }
}

export type Previewing = ReturnType<typeof usePreviewing>
