// Measured on the page of a run: a change in an outline of 100,000 rows, and from an event to its pixel.
import { nextTick } from 'vue'
import type { Pretended } from './pretended'

/** Milliseconds, one per repetition. */
export interface Figures {
  title: string
  ms: number[]
  budget_ms: number
  /** If it is not ms. */
  unit?: string
}

const CHANGES = 60
const EVENTS_PER_S = 50
const PATCH_EVERY_MS = 100
const SECONDS = 12
const HOUR = 36_000

export const frame = (): Promise<number> => new Promise((resolve) => requestAnimationFrame(resolve))

/** With all points open, ten visible ones change: until the rows are rendered and laid out. */
export async function measureOutline(server: Pretended): Promise<Figures> {
  const rows = [...document.querySelectorAll<HTMLElement>('[role="row"]')]
  rows.find((row) => row.textContent?.includes('100,000 points'))?.click()
  await nextTick()
  const box = document.querySelector<HTMLElement>('[role="treegrid"]')
  if (!box || Number(box.getAttribute('aria-rowcount')) < 100_000) throw new Error('the outline does not have 100,000 rows')
  const ms: number[] = []
  for (let i = 0; i < CHANGES; i++) {
    const first = 1000 * i
    box.scrollTop = first * 28
    await frame()
    await frame()
    const indexes = Array.from({ length: 10 }, (_, k) => first + k)
    const began = performance.now()
    server.done(indexes, 10 * (i + 1))
    await nextTick()
    void box.offsetHeight
    ms.push(performance.now() - began)
    await frame()
  }
  if (!/ok/.test(box.textContent ?? '')) throw new Error('the change was not drawn')
  return { title: 'outline of 100,000 rows: one change', ms, budget_ms: 50 }
}

/** 50 events per second, sent in patches as the server does; each until the frame in which its cell changes colour. */
export async function measureMap(server: Pretended): Promise<Figures> {
  await frame()
  const canvas = document.querySelector<HTMLCanvasElement>('[aria-roledescription="map"] canvas')
  const ctx = canvas?.getContext('2d')
  if (!canvas || !ctx) throw new Error('there is no map')
  const ms: number[] = []
  let waiting: { index: number; at: number }[] = []
  const drawing: { index: number; at: number; before: string }[] = []
  let next = 0
  const begun = performance.now()
  const events = setInterval(() => {
    const due = Math.floor(((performance.now() - begun) / 1000) * EVENTS_PER_S)
    while (next < Math.min(due, server.total)) waiting.push({ index: next++, at: performance.now() })
  }, 1000 / EVENTS_PER_S)
  const patches = setInterval(() => {
    if (!waiting.length) return
    drawing.push(...waiting.map((one) => ({ ...one, before: pixel(canvas, ctx, one.index) })))
    server.done(waiting.map((one) => one.index), next)
    waiting = []
  }, PATCH_EVERY_MS)
  while (performance.now() - begun < SECONDS * 1000) {
    await frame()
    await new Promise((resolve) => setTimeout(resolve, 0)) // after this frame was drawn
    for (let i = drawing.length - 1; i >= 0; i--) {
      const one = drawing[i]
      if (!one || pixel(canvas, ctx, one.index) === one.before) continue
      ms.push(performance.now() - one.at)
      drawing.splice(i, 1)
    }
  }
  clearInterval(events)
  clearInterval(patches)
  if (ms.length < EVENTS_PER_S * SECONDS * 0.8) throw new Error(`only ${ms.length} of ${next} events were drawn`)
  return { title: '1,071 points, 50 events/s: event to pixel (including the 100 ms in which patches are collected)', ms, budget_ms: 200 }
}

/** As many patches as an hour has, on the page of 100,000 points that are all known: what the heap holds after each sixth of them. */
export async function measureHour(server: Pretended): Promise<Figures> {
  for (let first = 0; first < server.total; first += 500) {
    server.done(Array.from({ length: 500 }, (_, k) => first + k), first + 500)
    await frame()
  }
  const heap: number[] = []
  for (let sent = 0; sent < HOUR; sent++) {
    server.done([0, 1, 2].map((k) => (3 * sent + k) % server.total), Math.min(3 * sent, server.total))
    if (sent % 50 === 49) await frame()
    if ((sent + 1) % (HOUR / 6) !== 0) continue
    await new Promise((resolve) => setTimeout(resolve, 1_000))
    heap.push((await window.heapUsed()) / 1e6)
  }
  const drawn = document.body.textContent
  if (!drawn.includes('ok 100,000')) throw new Error('the patches were not drawn')
  const grown = (heap.at(-1) ?? 0) - (heap[0] ?? 0)
  return { title: `100,000 points, ${HOUR.toLocaleString('en')} patches: growth of the heap in MB, of ${heap.map((mb) => mb.toFixed(2)).join(', ')}`, ms: [grown], budget_ms: 2, unit: 'MB' }
}

/** The colour near a corner of a cell, away from the icon. */
function pixel(canvas: HTMLCanvasElement, ctx: CanvasRenderingContext2D, index: number): string {
  const ratio = devicePixelRatio
  const [w, h] = [canvas.width / ratio, canvas.height / ratio]
  const cell = Math.floor(Math.min(w / 21, h / 51, 64))
  const left = Math.floor((w - cell * 21) / 2)
  const top = Math.floor((h - cell * 51) / 2)
  const x = left + (index % 21) * cell + 1
  const y = top + (50 - Math.floor(index / 21)) * cell + 1
  return ctx.getImageData(Math.round(x * ratio), Math.round(y * ratio), 1, 1).data.join()
}
