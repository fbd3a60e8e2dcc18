// Every request to the server: typed by the API description, with refusals thrown as sentences.
import createClient, { type Middleware } from 'openapi-fetch'
import { serverNow } from './clock'
import { keptLease } from './lease'
import { noAnswer, Refused } from './refused'
import type { Fault, Whole } from './types'
import type { paths } from './types.gen'

/** A command that reaches the server later than this is refused there and not done. */
export const DEADLINE_MS = 2_000
/** The server answers a command within two seconds; after this the page stops waiting. */
export const ANSWER_MS = 6_000
const READ_MS = 60_000

/** Each click has its own key; everything that may change something carries deadline and lease. */
const headers: Middleware = {
  onRequest({ request }) {
    if (request.method === 'GET') return request
    if (!request.headers.has('Idempotency-Key')) {
      request.headers.set('Idempotency-Key', newKey())
    }
    request.headers.set('X-Deadline', String(Math.round(serverNow() + DEADLINE_MS)))
    const lease = keptLease()
    if (lease !== null) request.headers.set('X-Control-Lease', lease)
    return request
  },
}

/** `api.GET('/api/v1/runs')`; pass the promise to `read` or `command`. */
export const api = createClient<paths>({
  baseUrl: typeof location === 'undefined' ? '' : location.origin,
  fetch: (request) => globalThis.fetch(request),
})
api.use(headers)

interface Answer<T> {
  data?: T
  error?: unknown
  response: Response
}

/** The answer, or a `Refused`. For reads, and for edits, which carry a revision. */
export async function read<T>(asked: Promise<Answer<T>>): Promise<Whole<T>> {
  let answer: Answer<T>
  try {
    answer = await within(asked, READ_MS)
  } catch (failure) {
    if (failure instanceof Refused) throw failure
    throw noAnswer('OFFLINE', 'the server did not answer', 'try again')
  }
  if (answer.response.ok) return answer.data as Whole<T>
  throw refusal(answer)
}

let live: () => boolean = () => true

/** Set how the client learns whether there is a connection. */
export function commandsNeed(connected: () => boolean): void {
  live = connected
}

/**
 * Do something to the bench or a run, once, now, or not at all: nothing is sent while offline,
 * and nothing is ever sent again. Takes a function, so that the request is not even created before.
 */
export async function command<T>(ask: () => Promise<Answer<T>>): Promise<Whole<T>> {
  if (!live()) {
    throw noAnswer('OFFLINE', 'not sent: no connection', 'try again when the page is live')
  }
  let answer: Answer<T>
  try {
    answer = await within(ask(), ANSWER_MS)
  } catch (failure) {
    if (failure instanceof Refused) throw failure
    throw noAnswer(
      'NO_ANSWER',
      'no answer: it may or may not have been done',
      'check the device or the run; it will not be sent again',
    )
  }
  if (answer.response.ok) return answer.data as Whole<T>
  throw refusal(answer)
}

/** A new key for a click. */
export function newKey(): string {
  const bytes = crypto.getRandomValues(new Uint8Array(16))
  return Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('')
}

function refusal(answer: Answer<unknown>): Refused {
  const fault = answer.error as Partial<Fault> | undefined
  if (typeof fault?.message === 'string') return new Refused(answer.response.status, fault as Fault)
  const status = answer.response.status
  return new Refused(status, {
    code: 'REFUSED', message: `the server answered ${status}`, hint: '', problems: [], details: {},
  })
}

async function within<T>(asked: Promise<T>, ms: number): Promise<T> {
  let timer: ReturnType<typeof setTimeout> | undefined
  const late = new Promise<never>((_, reject) => {
    timer = setTimeout(() => reject(new Error('late')), ms)
  })
  try {
    return await Promise.race([asked, late])
  } finally {
    clearTimeout(timer)
  }
}
