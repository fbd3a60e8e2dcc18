// Looking through a camera again and again, while somebody looks; nothing of it is kept.
import { computed, onMounted, onScopeDispose, ref, watch, type Ref } from 'vue'
import { api, read } from '../api/client'
import { sentenceOf } from '../api/refused'
import { useSession } from '../app/session'

/** After a look that failed, the next one comes no sooner. */
const PATIENCE_MS = 3_000

/** `camera` is empty while nobody wants to look; `place` is where the picture is shown: out of sight, nobody looks. */
export function useLooking(camera: () => string, place: Readonly<Ref<HTMLElement | null>>) {
  const session = useSession()
  const address = ref('')
  const seenAt = ref(0)
  const failure = ref('')
  const over = ref(false)
  const minutes = computed(() => session.all?.settings.look_for_min ?? 10)
  const inSight = ref(true)
  let wanted = 0
  let timer: ReturnType<typeof setTimeout> | undefined
  let looking = false
  let ended = false
  let sight: IntersectionObserver | undefined

  async function look(): Promise<void> {
    clearTimeout(timer)
    const device = camera()
    if (ended || looking || !device || over.value || document.hidden || !inSight.value) return
    if (Date.now() - wanted > minutes.value * 60_000) return void (over.value = true)
    looking = true
    const began = Date.now()
    try {
      const picture = await read<unknown>(api.GET('/api/v1/devices/{device}/picture', { params: { path: { device } }, parseAs: 'blob' }))
      if (!ended && device === camera()) show(URL.createObjectURL(picture as Blob))
      failure.value = ''
    } catch (fault) {
      if (device === camera()) failure.value = sentenceOf(fault)
    } finally {
      looking = false
    }
    const every = 1000 * (session.all?.settings.look_every_s ?? 1)
    if (!ended) timer = setTimeout(look, Math.max(0, began + (failure.value ? Math.max(every, PATIENCE_MS) : every) - Date.now()))
  }
  function show(picture: string): void {
    if (address.value) URL.revokeObjectURL(address.value)
    address.value = picture
    seenAt.value = picture ? Date.now() : 0
  }
  function goOn(): void {
    over.value = false
    wanted = Date.now()
    void look()
  }

  watch(camera, () => {
    show('')
    failure.value = ''
    goOn()
  })
  const seen = (): void => void look()
  onMounted(async () => {
    document.addEventListener('visibilitychange', seen)
    if (place.value) {
      sight = new IntersectionObserver(([entry]) => {
        inSight.value = entry?.isIntersecting ?? true
        void look()
      })
      sight.observe(place.value)
    }
    if (!session.all) await session.loadSettings().catch(() => undefined) // its defaults will do
    void look()
  })
  onScopeDispose(() => {
    ended = true
    clearTimeout(timer)
    sight?.disconnect()
    document.removeEventListener('visibilitychange', seen)
    show('')
  })
  return { address, seenAt, failure, over, minutes, goOn }
}
