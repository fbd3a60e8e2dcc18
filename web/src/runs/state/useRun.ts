// One run, watched while a page shows it: sent whole, then as patches, and whole again after each gap.
import { onScopeDispose, shallowRef, watch, type Ref } from 'vue'
import { useConnection } from '../../api/updates/connection'
import { askSocket, say } from '../../api/updates/socket'
import { Refused } from '../../api/refused'
import type { RunLog, RunPatch, WatchedRun } from '../../api/types'
import { RunPicture, type Change } from '../picture'
import { loadPoints } from './loadPoints'

/** A server that is too busy to answer is asked again after this. */
const AGAIN_MS = 1_000

export interface LiveRun {
  /** Null until the run has arrived, and if there is none. */
  picture: Ref<RunPicture | null>
  /** Incremented by every change in the picture. */
  version: Ref<number>
  /** Why there is no picture. */
  failure: Ref<string>
  onChange: (tell: (change: Change) => void) => void
  onLog: (tell: (log: RunLog) => void) => void
}

/** Watch the run with this id; ends with the calling component. */
export function useRun(id: () => string): LiveRun {
  const connection = useConnection()
  const picture = shallowRef<RunPicture | null>(null)
  const version = shallowRef(0)
  const failure = shallowRef('')
  const changed = new Set<(change: Change) => void>()
  const logged = new Set<(log: RunLog) => void>()
  const early: RunPatch[] = []
  let asking = 0
  let loading = false
  let timer: ReturnType<typeof setTimeout> | undefined

  async function whole(run: string): Promise<void> {
    const socket = connection.line()
    if (socket?.connected !== true) return
    const mine = ++asking
    clearTimeout(timer)
    loading = true
    early.length = 0
    try {
      const told = await askSocket<WatchedRun>(socket, 'watch', { run })
      if (mine !== asking) return
      failure.value = told.ok ? '' : told.text
      if (!told.run) return
      const made = new RunPicture(told.run)
      await loadPoints(made)
      if (mine !== asking) return
      // Apply what came while points were loading; skip what the windows already contain.
      early.forEach((patch) => made.take(patch))
      if (!made.head.live) made.filled().forEach((table) => table.settle())
      picture.value = made
      version.value++
    } catch (fault) {
      if (mine !== asking) return
      const refused = fault instanceof Refused && fault.status > 0
      failure.value = refused ? fault.sentence : 'The server has not answered yet; it is asked again'
      if (!refused) timer = setTimeout(again, AGAIN_MS)
    } finally {
      if (mine === asking) loading = false
    }
  }

  function take(patch: RunPatch): void {
    if (patch.run !== id()) return
    if (loading) early.push(patch)
    if (loading || !picture.value) return
    const wasLive = picture.value.head.live
    const change = picture.value.take(patch)
    // At its end a run has outputs, which no patch contains.
    if (change === null || (wasLive && !patch.head.live)) {
      void whole(patch.run)
      return
    }
    version.value++
    changed.forEach((tell) => tell(change))
  }
  function log(told: RunLog): void {
    if (told.run === id()) logged.forEach((tell) => tell(told))
  }
  const again = (): void => void whole(id())

  let line = connection.line()
  function attach(): void {
    line = connection.line()
    line?.on('run_patch', take)
    line?.on('log', log)
    line?.on('snapshot', again)
    again()
  }
  function detach(): void {
    line?.off('run_patch', take)
    line?.off('log', log)
    line?.off('snapshot', again)
  }

  // The connection exists from the first snapshot on.
  const waiting = watch(
    () => connection.bench.seq >= 0,
    (there) => {
      if (!there) return
      detach()
      attach()
    },
    { immediate: true },
  )
  watch(id, (now, before) => {
    if (line) say(line, 'unwatch', { run: before })
    picture.value = null
    void whole(now)
  })
  onScopeDispose(() => {
    asking++
    clearTimeout(timer)
    waiting()
    detach()
    if (line) say(line, 'unwatch', { run: id() })
  })
  return {
    picture, version, failure,
    onChange: (tell) => changed.add(tell),
    onLog: (tell) => logged.add(tell),
  }
}
