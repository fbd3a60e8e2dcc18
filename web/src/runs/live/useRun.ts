// One run, watched for as long as a page looks at it: told whole, then by patches, again after each gap.
import { onScopeDispose, shallowRef, watch, type Ref } from 'vue'
import { useLive } from '../../api/push/live'
import { askSocket, say } from '../../api/push/socket'
import { sentenceOf } from '../../api/refused'
import type { RunLog, RunPatch, Watched } from '../../api/types'
import { RunPicture, type Change } from '../picture'
import { loadPoints } from './loadPoints'

export interface LiveRun {
  /** Null until the run was told, and where there is none. */
  picture: Ref<RunPicture | null>
  /** Counts up with everything that has changed in the picture. */
  version: Ref<number>
  /** Why there is no picture, in words. */
  failure: Ref<string>
  onChange: (tell: (change: Change) => void) => void
  onLog: (tell: (log: RunLog) => void) => void
}

/** Watch the run with this id; ends with the component that asked. */
export function useRun(id: () => string): LiveRun {
  const live = useLive()
  const picture = shallowRef<RunPicture | null>(null)
  const version = shallowRef(0)
  const failure = shallowRef('')
  const changed = new Set<(change: Change) => void>()
  const logged = new Set<(log: RunLog) => void>()
  const early: RunPatch[] = []
  let asking = 0
  let loading = false

  async function whole(run: string): Promise<void> {
    const socket = live.line()
    if (socket?.connected !== true) return
    const mine = ++asking
    loading = true
    early.length = 0
    try {
      const told = await askSocket<Watched>(socket, 'watch', { run })
      if (mine !== asking) return
      failure.value = told.ok ? '' : told.text
      if (!told.run) return
      const made = new RunPicture(told.run)
      await loadPoints(made)
      if (mine !== asking) return
      // What came while points were loading is taken now; what the windows held already is passed over.
      early.forEach((patch) => made.take(patch))
      if (!made.head.live) made.filled().forEach((table) => table.settle())
      picture.value = made
      version.value++
    } catch (fault) {
      if (mine === asking) failure.value = sentenceOf(fault)
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
    // At its end a run has outputs, which no patch tells.
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

  let line = live.line()
  function attach(): void {
    line = live.line()
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

  // The line is there from the first snapshot on.
  const waiting = watch(
    () => live.bench.seq >= 0,
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
