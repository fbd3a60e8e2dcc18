// The bench as a camera sees it from above, to lie under what is drawn on it.
import { computed, onScopeDispose, ref, shallowRef } from 'vue'
import { api, read } from '../../api/client'
import { sentenceOf } from '../../api/refused'
import { useConnection } from '../../api/updates/connection'
import type { Box } from './drawing'

/** A picture, and where on the bench it lies. */
export interface Photograph extends Box {
  picture: CanvasImageSource
}

/** What `X-Bench` says: left, right, front and back in mm. */
export function placeOf(header: string | null): Box | null {
  const edges = (header ?? '').split(' ').map(Number)
  const [left = 0, right = 0, front = 0, back = 0] = edges
  return edges.length === 4 && right > left && back > front ? { x: left, y: front, width: right - left, height: back - front } : null
}

/** The cameras that may know where they are; the first is one that does, if there is one. */
export function useCameras() {
  const connection = useConnection()
  const all = computed(() => Object.values(connection.bench.devices).filter((one) => one.contract.startsWith('depth_camera@')))
  return { all, knowing: computed(() => all.value.find((one) => one.status['calibrated'] === true)) }
}

export function usePhotograph() {
  const { all, knowing } = useCameras()
  const camera = computed(() => knowing.value ?? all.value[0])
  const photograph = shallowRef<Photograph | null>(null)
  const failure = ref('')
  const looking = ref(false)
  let asked = 0

  async function look(): Promise<void> {
    const device = camera.value?.name
    if (device === undefined) return
    const mine = ++asked
    looking.value = true
    failure.value = ''
    try {
      const answer = api.GET('/api/v1/devices/{device}/picture', { params: { path: { device }, query: { above: true } }, parseAs: 'blob' })
      const picture = await createImageBitmap((await read<unknown>(answer)) as Blob)
      const place = placeOf((await answer).response.headers.get('X-Bench'))
      if (mine === asked && place) photograph.value = { picture, ...place }
    } catch (fault) {
      if (mine === asked) failure.value = sentenceOf(fault)
    } finally {
      if (mine === asked) looking.value = false
    }
  }
  function putAway(): void {
    asked++
    looking.value = false
    failure.value = ''
    photograph.value = null
  }
  onScopeDispose(putAway)
  return { camera, knows: computed(() => knowing.value !== undefined), photograph, failure, looking, look, putAway }
}
