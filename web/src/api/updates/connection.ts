// What the page knows about the bench now, and whether it still receives data from the server.
import { defineStore } from 'pinia'
import { computed, reactive, ref } from 'vue'
import type { Socket } from 'socket.io-client'
import { heardTime } from '../clock'
import { commandsNeed } from '../client'
import type { Notice, Patch, Snapshot } from '../types'
import { applyPatch, emptyBench, fromSnapshot } from './bench'
import { askSocket, openSocket } from './socket'

/** Devices send their status once a second: this long without a message means that the connection is dead. */
export const SILENT_MS = 3_000
const PROBE_MS = 1_000
const ENTER_MS = 2_000

/** The one store of what the server sends to everyone. Others only read `bench`. */
export const useConnection = defineStore('live', () => {
  const bench = reactive(emptyBench())
  const heard_at = ref(0)
  const now = ref(Date.now())
  const connected = ref(false)
  const latency_ms = ref<number | null>(null)
  const begun_at = Date.now()
  /** The browser reports no network, and the server cannot be reached either. */
  const cut = ref(false)
  const live = computed(() => connected.value && !cut.value && now.value - heard_at.value < SILENT_MS)
  const silent_s = computed(() => Math.max(0, (now.value - (heard_at.value || begun_at)) / 1000))
  const told = new Set<(notice: Notice) => void>()
  let socket: Socket | null = null
  let asking = false
  let entered_at = 0

  function heard(): void {
    heard_at.value = now.value = Date.now()
  }

  function takeAll(snapshot: Snapshot): void {
    heard()
    heardTime(snapshot.server_time_ms)
    Object.assign(bench, fromSnapshot(snapshot))
  }

  async function askAll(): Promise<void> {
    if (asking || socket === null) return
    asking = true
    try {
      takeAll(await askSocket<Snapshot>(socket, 'snapshot', {}))
    } catch {
      // Silence: drop the connection; a new one begins with a snapshot.
      socket.disconnect().connect()
    } finally {
      asking = false
    }
  }

  function takePatch(patch: Patch): void {
    heard()
    heardTime(patch.server_time_ms)
    if (!applyPatch(bench, patch)) void askAll()
  }

  /** A browser without network may still reach a server on its own machine: only a request shows it. */
  async function lookForNetwork(): Promise<void> {
    const asked = fetch('/api/v1/session', { cache: 'no-store', signal: AbortSignal.timeout(PROBE_MS) })
    cut.value = await asked.then(() => false, () => true)
  }

  /** `unwatch` of nothing is the smallest request that the server acknowledges. */
  async function probe(): Promise<void> {
    if (!navigator.onLine || cut.value) await lookForNetwork()
    if (socket?.connected !== true) return
    const began = performance.now()
    try {
      await askSocket(socket, 'unwatch', {}, SILENT_MS)
      latency_ms.value = Math.round(performance.now() - began)
      heard()
    } catch {
      latency_ms.value = null
    }
  }

  async function enterAgain(isLetIn: () => Promise<boolean>): Promise<void> {
    if (socket === null || Date.now() - entered_at < ENTER_MS) return
    entered_at = Date.now()
    if ((await isLetIn()) && socket !== null && !socket.connected) socket.disconnect().connect()
  }

  /** Start listening; `isLetIn` asks whether this browser is signed in. Returns the function that stops it. */
  function listen(isLetIn: () => Promise<boolean>, open: () => Socket = openSocket): () => void {
    socket = open()
    socket.on('connect', () => (connected.value = true))
    socket.on('disconnect', () => (connected.value = false))
    // The server was replaced, or no longer knows this browser: sign in again.
    socket.on('connect_error', () => void enterAgain(isLetIn))
    socket.on('snapshot', takeAll)
    socket.on('patch', takePatch)
    socket.on('notice', (notice: Notice) => told.forEach((tell) => tell(notice)))
    socket.connect()
    commandsNeed(() => {
      now.value = Date.now()
      return live.value
    })
    const lost = (): void => void lookForNetwork()
    window.addEventListener('offline', lost)
    window.addEventListener('online', lost)
    const ticking = setInterval(() => (now.value = Date.now()), 250)
    const probing = setInterval(() => void probe(), PROBE_MS)
    return () => {
      clearInterval(ticking)
      clearInterval(probing)
      window.removeEventListener('offline', lost)
      window.removeEventListener('online', lost)
      socket?.disconnect()
      socket = null
      connected.value = false
    }
  }

  /** Subscribe to notices; returns the function that ends it. */
  function onNotice(tell: (notice: Notice) => void): () => void {
    told.add(tell)
    return () => told.delete(tell)
  }

  /** The connection itself, for watching a run (`askSocket`) and for keep-alives (`say`). */
  function line(): Socket | null {
    return socket
  }

  /** Try to connect now. */
  function retry(): void {
    socket?.disconnect().connect()
  }

  return { bench, live, now, heard_at, silent_s, latency_ms, listen, onNotice, line, retry }
})
