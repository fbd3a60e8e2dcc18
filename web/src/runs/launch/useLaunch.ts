// What a protocol asks before it runs: its form, the result of its check, how long it will take.
import { computed, onScopeDispose, reactive, ref, shallowRef, watch } from 'vue'
import { api, read } from '../../api/client'
import { Refused, sentenceOf } from '../../api/refused'
import type { Problem, Settings, Received } from '../../api/types'
import { chosen, fault, shown, shownDefault } from './params'

const WAIT_MS = 300
const AGAIN_MS = 5_000
type Checked = Received<'CheckedText'>
type Preview = Received<'Preview'>

/** Where the last used parameters of a protocol are kept in this browser. */
export const keptParams = (protocol: string): string => `labrun.params.${protocol}`

export function useLaunch(protocol: () => string) {
  const text = shallowRef<Received<'ProtocolText'> | null>(null)
  const checked = shallowRef<Checked | null>(null)
  const preview = shallowRef<Preview | null>(null)
  const settings = shallowRef<Settings | null>(null)
  const problems = shallowRef<readonly Problem[]>([])
  const failure = ref('')
  const looking = ref(false)
  const typed = reactive<Record<string, string>>({})
  const bind = reactive<Record<string, string>>({})
  let timer: ReturnType<typeof setTimeout> | undefined
  let asked = 0

  const params = computed(() => chosen(checked.value?.params ?? [], typed))
  const wrong = computed(() => (checked.value?.params ?? []).filter((one) => fault(one, typed[one.name] ?? '') !== ''))
  const body = computed(() => ({
    text: text.value?.text ?? '', name: protocol(), params: params.value, bind: { ...bind },
  }))

  async function open(): Promise<void> {
    asked++
    clearTimeout(timer)
    failure.value = ''
    checked.value = preview.value = null
    for (const name of Object.keys(typed)) Reflect.deleteProperty(typed, name)
    try {
      const [told, all] = await Promise.all([
        read(api.GET('/api/v1/protocols/{name}', { params: { path: { name: protocol() } } })),
        read(api.GET('/api/v1/settings')),
      ])
      text.value = told
      settings.value = all.settings
      await look()
    } catch (fault) {
      failure.value = sentenceOf(fault)
    }
  }

  /** Request check and preview for the current input. */
  async function look(): Promise<void> {
    const mine = ++asked
    looking.value = true
    try {
      const told = await read(api.POST('/api/v1/check', { body: body.value }))
      if (mine !== asked) return
      // A form with an invalid value comes without its fields: the existing ones stay.
      checked.value = told.params.length || !checked.value ? told : { ...told, params: checked.value.params, roles: checked.value.roles, hazards: checked.value.hazards }
      problems.value = told.problems
      fill()
      const seen = told.ok ? (await read(api.POST('/api/v1/preview', { body: body.value }))) : null
      if (mine !== asked) return
      preview.value = seen
      failure.value = ''
    } catch (fault) {
      if (mine !== asked || (fault instanceof Refused && fault.status === 422)) return
      failure.value = sentenceOf(fault)
      timer = setTimeout(() => void look(), AGAIN_MS)
    } finally {
      if (mine === asked) looking.value = false
    }
  }

  /** The fields of a new form: defaults, or the values used last. */
  function fill(): void {
    if (Object.keys(typed).length) return
    for (const one of checked.value?.params ?? []) typed[one.name] = shownDefault(one)
    const kept = sessionStorage.getItem(keptParams(protocol()))
    if (kept !== null) take(JSON.parse(kept) as Record<string, unknown>)
  }

  /** Fill the fields with values, such as those of an earlier run. */
  function take(values: Readonly<Record<string, unknown>>): void {
    for (const one of checked.value?.params ?? [])
      if (one.name in values) typed[one.name] = shown(one, values[one.name])
  }

  /** Every field at its default. */
  function defaults(): void {
    for (const one of checked.value?.params ?? []) typed[one.name] = shownDefault(one)
    sessionStorage.removeItem(keptParams(protocol()))
  }

  // By what it says: the answer of a check makes the parameters anew, though they are the same.
  watch(() => JSON.stringify([params.value, bind]), () => {
    clearTimeout(timer)
    if (!text.value || wrong.value.length > 0) return
    looking.value = true
    timer = setTimeout(() => void look(), WAIT_MS)
  })
  watch(protocol, () => void open(), { immediate: true })
  onScopeDispose(() => clearTimeout(timer))
  return { text, checked, preview, settings, problems, failure, looking, typed, bind, params, wrong, defaults }
}
