import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest'
import { ANSWER_MS, api, command, commandsNeed, DEADLINE_MS, read } from './client'
import { forgetTime, heardTime } from './clock'
import { keepLease } from './lease'
import { Refused } from './refused'

let sent: Request[] = []
let answer: () => Promise<Response>

beforeEach(() => {
  sent = []
  answer = () => Promise.resolve(Response.json({ text: 'done' }))
  vi.stubGlobal('fetch', (request: Request) => {
    sent.push(request)
    return answer()
  })
  commandsNeed(() => true)
  forgetTime()
  keepLease(null)
})
afterEach(() => {
  vi.useRealTimers()
  vi.unstubAllGlobals()
})

const pause = () => command(() => api.POST('/api/v1/runs/{id}/pause', { params: { path: { id: 'r' } }, body: { when: 'now' } }))
const failure = (asked: Promise<unknown>) => asked.then(() => null, (why: unknown) => why as Refused)

describe('a command', () => {
  it('has its own key, a deadline by the server’s clock, and the lease', async () => {
    heardTime(Date.now() + 3_600_000)
    keepLease({ lease: 'secret', since: null })
    await pause()
    await pause()
    const [first, second] = sent.map((one) => one.headers)

    expect(first?.get('Idempotency-Key')).toMatch(/^[0-9a-f]{32}$/)
    expect(second?.get('Idempotency-Key')).not.toBe(first?.get('Idempotency-Key'))
    expect(first?.get('X-Control-Lease')).toBe('secret')

    const ahead = Number(first?.get('X-Deadline')) - Date.now()

    expect(ahead).toBeGreaterThan(3_590_000)
    expect(ahead).toBeLessThanOrEqual(3_600_000 + DEADLINE_MS)
  })

  it('is not sent while there is no connection, and not later either', async () => {
    commandsNeed(() => false)
    const why = await failure(pause())

    expect(why?.fault.code).toBe('OFFLINE')

    commandsNeed(() => true)
    await new Promise((resolve) => setTimeout(resolve, 50))

    expect(sent).toEqual([])
  })

  it('without an answer is given up, once, without a claim that it was not done', async () => {
    vi.useFakeTimers()
    answer = () => new Promise(() => undefined)
    const asked = failure(pause())
    await vi.advanceTimersByTimeAsync(ANSWER_MS + 1)
    const why = await asked

    expect(why?.fault.code).toBe('NO_ANSWER')
    expect(why?.sentence).toContain('may or may not have been done')
    expect(sent).toHaveLength(1)
  })

  it('that is refused gives the server’s reason', async () => {
    const fault = { code: 'HELD', message: 'a run has it', hint: 'wait', problems: [], details: {} }
    answer = () => Promise.resolve(Response.json(fault, { status: 409 }))
    const why = await failure(pause())

    expect([why?.status, why?.sentence]).toEqual([409, 'A run has it. Wait'])
  })
})

describe('a question', () => {
  it('is also sent while nothing is received, without a key', async () => {
    commandsNeed(() => false)
    answer = () => Promise.resolve(Response.json([]))

    expect(await read(api.GET('/api/v1/runs'))).toEqual([])
    expect(sent[0]?.headers.has('Idempotency-Key')).toBe(false)
  })

  it('that cannot be sent is reported as a sentence', async () => {
    answer = () => Promise.reject(new TypeError('Failed to fetch'))
    const why = await failure(read(api.GET('/api/v1/runs')))

    expect(why).toBeInstanceOf(Refused)
    expect(why?.message).toBe('the server did not answer')
  })
})
