import { createPinia, setActivePinia } from 'pinia'
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest'
import type { Socket } from 'socket.io-client'
import { useConnection } from '../api/updates/connection'
import type { Stopped } from '../api/types'
import { ALARM_MS, useStop } from './stop'

const told = (confirmed: boolean): Stopped => ({
  all_confirmed: confirmed, at: '', runs: [],
  devices: [
    { device: 'gantry', confirmed: true, message: '', seconds: 0.1 },
    { device: 'libs', confirmed, message: 'no answer', seconds: 0.9 },
  ],
})

beforeEach(() => setActivePinia(createPinia()))
afterEach(() => {
  vi.useRealTimers()
  vi.unstubAllGlobals()
})

describe('STOP ALL', () => {
  it('is sent even if the page receives nothing', async () => {
    const fetched = vi.fn(() => Promise.resolve(Response.json(told(true))))
    vi.stubGlobal('fetch', fetched)
    const stop = useStop()
    await stop.stopAll()

    expect(fetched).toHaveBeenCalledOnce()
    expect(stop.state).toBe('confirmed')
  })

  it('is one stop for each press, by whichever route', async () => {
    const emitted: { press: string }[] = []
    const emitWithAck = (_: string, asked: { press: string }) => {
      emitted.push(asked)
      return Promise.resolve(told(true))
    }
    const socket = { connected: true, volatile: { timeout: () => ({ emitWithAck }) } }
    vi.spyOn(useConnection(), 'line').mockReturnValue(socket as unknown as Socket)
    const fetched = vi.fn<(path: string, asked: { headers: Record<string, string> }) => unknown>()
    fetched.mockImplementation(() => Promise.resolve(Response.json(told(true))))
    vi.stubGlobal('fetch', fetched)
    const stop = useStop()
    await stop.stopAll()
    await stop.stopAll()
    const posted = fetched.mock.calls.map(([, asked]) => asked.headers['Idempotency-Key'])

    expect(emitted.map((asked) => asked.press)).toEqual(posted)
    expect(new Set(posted).size).toBe(2)
  })

  it('is an alarm that names the devices that did not confirm', async () => {
    vi.stubGlobal('fetch', () => Promise.resolve(Response.json(told(false))))
    const stop = useStop()
    await stop.stopAll()

    expect(stop.state).toBe('alarm')
    expect(stop.silent).toEqual(['libs'])
  })

  it('is an alarm after a second of silence, and still accepts a late answer', async () => {
    vi.useFakeTimers()
    let answer: (response: Response) => void = () => undefined
    vi.stubGlobal('fetch', () => new Promise<Response>((resolve) => (answer = resolve)))
    const stop = useStop()
    const stopping = stop.stopAll()
    await vi.advanceTimersByTimeAsync(ALARM_MS + 1)

    expect(stop.state).toBe('alarm')

    answer(Response.json(told(true)))
    await stopping

    expect(stop.state).toBe('confirmed')
  })

  it('is an alarm at once if nothing can be reached', async () => {
    vi.stubGlobal('fetch', () => Promise.reject(new TypeError('Failed to fetch')))
    const stop = useStop()
    await stop.stopAll()

    expect([stop.state, stop.failure]).toEqual(['alarm', 'the server did not answer'])
  })
})
