// One number over the runs found, with limits; the choice is in the address, so that a link leads to the same.
import { computed, shallowRef, watch, type Ref } from 'vue'
import { useRoute, useRouter } from 'vue-router'
import { api, read } from '../api/client'
import { sentenceOf } from '../api/refused'
import type { Received } from '../api/types'
import { pointed, figures } from '../ui/format'

export type Over = Received<'RunNumbers'>

/** Asked again when `found` is: a run that ends may have the number. */
export function useNumber(find: Ref<string>, found: Ref<unknown>) {
  const route = useRoute()
  const router = useRouter()
  const kept = (name: string) => computed({
    get: () => (typeof route.query[name] === 'string' ? route.query[name] : ''),
    set: (text) => void router.replace({ query: { ...route.query, [name]: pointed(text) || undefined, ...(name === 'value' ? { low: undefined, high: undefined } : {}) } }),
  })
  const [value, low, high] = [kept('value'), kept('low'), kept('high')]
  const over = shallowRef<Over | null>(null)
  const failure = shallowRef('')
  watch([value, low, high, find, found], async (now) => {
    const asked = (): boolean => [value, low, high, find].every((one, i) => one.value === now[i])
    if (!value.value) return void ([over.value, failure.value] = [null, ''])
    try {
      const told = await read(api.GET('/api/v1/found/numbers', { params: { query: { name: value.value, low: low.value, high: high.value, find: find.value } } }))
      if (asked()) [over.value, failure.value] = [told, '']
    } catch (fault) {
      if (asked()) [over.value, failure.value] = [null, sentenceOf(fault)]
    }
  }, { immediate: true })

  function words({ value: number, out }: Over['runs'][number]): string {
    const { unit, low: least, high: most } = over.value ?? { unit: '', low: null, high: null }
    const [limit, way] = most !== null && number > most ? [most, 'above'] : [least ?? 0, 'below']
    return `${figures(number)}${unit && ` ${unit}`}${out ? `, ${way} ${figures(limit)}` : ''}`
  }
  /** Run -> what lies beyond a limit. */
  const beyond = computed(() => new Map((over.value?.runs ?? []).filter((one) => one.out).map((one) => [one.run, `${value.value} ${words(one)}`])))
  return { value, low, high, over, failure, words, beyond }
}
