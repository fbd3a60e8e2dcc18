// Jogging: one bounded step per press, or a hold that lasts only while keep-alives arrive.
import { computed, onScopeDispose, ref } from 'vue'
import { onBeforeRouteLeave } from 'vue-router'
import { api, command } from '../../api/client'
import { useConnection } from '../../api/updates/connection'
import { say } from '../../api/updates/socket'
import { sentenceOf } from '../../api/refused'
import { useRecording } from '../recording'
import type { Axis, Way } from './axes'

/** The axis stops by itself after so long without a word from this page. */
const DEAD_MAN_MS = 300

interface Press {
  released: boolean
  id: string | null
  beating: ReturnType<typeof setInterval> | undefined
}

/** A way as the server takes it: one axis, and those that go along with it. */
function split(way: Way): { axis: Axis; direction: 1 | -1; along: Way } {
  const [[axis, direction], ...along] = Object.entries(way) as [[Axis, 1 | -1], ...[Axis, 1 | -1][]]
  return { axis, direction, along: Object.fromEntries(along) }
}

/** Holds end when anything takes the hand or the eye away. */
export function useJogging(device: () => string) {
  const connection = useConnection()
  const recording = useRecording()
  const said = ref('')
  const sending = ref(false)
  let press: Press | null = null
  let ending: Promise<void> = Promise.resolve()
  const held = ref<string | null>(null)
  const moving = computed(() => held.value !== null && connection.bench.jogs[held.value]?.moving !== false)

  /** The move is relative to the position known to the server, which checks it. */
  async function step(way: Way, by_mm: number, feed_mm_min: number | null): Promise<void> {
    if (sending.value) return
    sending.value = true
    said.value = ''
    const path = { device: device() }
    const { direction, ...axes } = split(way)
    try {
      const goal = await command(() =>
        api.POST('/api/v1/devices/{device}/jog/step', { params: { path }, body: { ...axes, distance_mm: direction * by_mm, feed_mm_min } }),
      )
      recording.follow(goal)
      if (goal.error !== null) said.value = goal.error.message
    } catch (failure) {
      said.value = sentenceOf(failure)
    } finally {
      sending.value = false
    }
  }

  /** A hold that is under way ends first: the hand has changed its mind. */
  async function hold(way: Way, feed_mm_min: number): Promise<void> {
    letGo()
    const mine: Press = { released: false, id: null, beating: undefined }
    press = mine
    await ending
    if (mine.released) return
    said.value = ''
    const path = { device: device() }
    try {
      const jog = await command(() =>
        api.POST('/api/v1/devices/{device}/jog/start', { params: { path }, body: { ...split(way), feed_mm_min, dead_man_ms: DEAD_MAN_MS } }),
      )
      mine.id = jog.id
      if (mine.released) await end(mine)
      else {
        held.value = jog.id
        beat(jog.id)
        mine.beating = setInterval(() => beat(jog.id), jog.beat_ms)
      }
    } catch (failure) {
      said.value = sentenceOf(failure)
      if (press === mine) press = null
    }
  }

  /** Without a connection nothing is sent, and the server's dead-man stops the axis. */
  function beat(id: string): void {
    const socket = connection.line()
    if (socket !== null) say(socket, 'jog', { id })
    if (connection.bench.jogs[id]?.moving === false) letGo()
  }

  function letGo(): void {
    const mine = press
    if (mine === null) return
    press = null
    held.value = null
    mine.released = true
    clearInterval(mine.beating)
    ending = end(mine)
  }

  async function end(mine: Press): Promise<void> {
    if (mine.id === null) return
    const path = { id: mine.id }
    try {
      const jog = await command(() => api.POST('/api/v1/jogs/{id}/stop', { params: { path } }))
      if (jog.reason !== '' && jog.reason !== 'let go') said.value = jog.reason
    } catch {
      said.value = 'the stop was not confirmed; without keep-alives the server stops the axis'
    }
  }

  const hidden = (): void => {
    if (document.hidden) letGo()
  }
  window.addEventListener('blur', letGo)
  window.addEventListener('pointerup', letGo)
  window.addEventListener('pointercancel', letGo)
  document.addEventListener('visibilitychange', hidden)
  onBeforeRouteLeave(() => letGo())
  onScopeDispose(() => {
    letGo()
    window.removeEventListener('blur', letGo)
    window.removeEventListener('pointerup', letGo)
    window.removeEventListener('pointercancel', letGo)
    document.removeEventListener('visibilitychange', hidden)
  })

  return { said, sending, moving, step, hold, letGo }
}
