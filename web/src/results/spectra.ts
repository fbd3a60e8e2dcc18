// Spectra and their wavelengths, loaded once: an axis never changes, the browser caches spectra.
import { api, read } from '../api/client'
import type { Received } from '../api/types'
import { decodeFit, decodeFloat32, type Fit } from './float32'

export type Peaks = Received<'Peaks'>

/** Counts over wavelengths in nm; both of the same length. */
export interface Spectrum {
  nm: Float32Array
  counts: Float32Array
  axis: string
}

const axes = new Map<string, Promise<Float32Array>>()
const KEPT = 64
const kept = new Map<string, Promise<Spectrum>>()

function axisOf(run: string, axis: string): Promise<Float32Array> {
  let known = axes.get(axis)
  if (!known) {
    known = binary(api.GET('/api/v1/runs/{id}/axes/{axis}', { params: { path: { id: run, axis } }, parseAs: 'arrayBuffer' })).then(({ bytes }) => decodeFloat32(bytes))
    axes.set(axis, known)
    known.catch(() => axes.delete(axis))
  }
  return known
}

/** One spectrum file of a run. */
export function spectrumOf(run: string, file: string): Promise<Spectrum> {
  const name = `${run}/${file}`
  const known = kept.get(name)
  if (known) return known
  const asked = fetched(run, file)
  kept.set(name, asked)
  asked.catch(() => kept.delete(name))
  if (kept.size > KEPT) kept.delete(kept.keys().next().value ?? '')
  return asked
}

async function fetched(run: string, file: string): Promise<Spectrum> {
  const told = await binary(api.GET('/api/v1/runs/{id}/spectrum', { params: { path: { id: run }, query: { file } }, parseAs: 'arrayBuffer' }))
  return withAxis(run, told)
}

/** The mean over selected points, and their number. */
export async function meanOf(run: string, loop: string, keys: string[]): Promise<Spectrum & { count: number }> {
  const told = await binary(
    api.POST('/api/v1/runs/{id}/mean', { params: { path: { id: run } }, body: { keys, loop }, parseAs: 'arrayBuffer' }),
  )
  return { ...(await withAxis(run, told)), count: Number(told.headers.get('X-Count') ?? keys.length) }
}

/** Background, fit and residual of one spectrum. */
export async function fitOf(run: string, file: string): Promise<Fit> {
  const told = await binary(api.GET('/api/v1/runs/{id}/fit', { params: { path: { id: run }, query: { file } }, parseAs: 'arrayBuffer' }))
  return decodeFit(told.bytes)
}

/** The reduction's result for one spectrum. */
export async function peaksOf(run: string, file: string): Promise<Peaks> {
  return await read(api.GET('/api/v1/runs/{id}/peaks', { params: { path: { id: run }, query: { file } } }))
}

async function withAxis(run: string, told: Binary): Promise<Spectrum> {
  const axis = told.headers.get('X-Axis') ?? ''
  const nm = await axisOf(run, axis)
  return { nm, counts: decodeFloat32(told.bytes, nm.length), axis }
}

interface Binary {
  bytes: ArrayBuffer
  headers: Headers
}

/** A binary answer with its headers; refusals are thrown as everywhere. */
export async function binary(asked: Promise<{ data?: unknown; error?: unknown; response: Response }>): Promise<Binary> {
  let headers = new Headers()
  const bytes = await read(
    asked.then((answer) => {
      headers = answer.response.headers
      return answer
    }),
  )
  return { bytes: bytes as ArrayBuffer, headers }
}
