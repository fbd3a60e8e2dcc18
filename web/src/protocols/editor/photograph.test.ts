// Where a photograph of the bench lies: the server says it, and a picture without a place is not shown.
import { expect, test, vi } from 'vitest'
import { draw, frameOf } from './drawing'
import { placeOf } from './photograph'

test('a photograph has the place that its header tells', () => {
  expect(placeOf('-20.5 730 0 810.25')).toEqual({ x: -20.5, y: 0, width: 750.5, height: 810.25 })
  for (const header of [null, '', '1 2 3', '5 5 0 1', 'a b c d']) expect(placeOf(header)).toBe(null)
})

test('it lies under the points by the same millimetres as they, upwards', () => {
  const track = { area: { x0: 0, x1: 100, y0: 0, y1: 100 }, allowed: { x0: 0, x1: 100, y0: 0, y1: 100 }, keep_out: [], outside: [], x_mm: [10], y_mm: [20], joined: [false], track: [0] } as unknown as Parameters<typeof draw>[1]
  const frame = frameOf(track, 400, 280, 'bench')
  const calls: unknown[][] = []
  const brush = new Proxy({}, { get: (_, name) => (...given: unknown[]) => calls.push([name, ...given]), set: () => true })
  const picture = {} as CanvasImageSource
  const canvas = Object.assign(document.createElement('canvas'), { getContext: vi.fn(() => brush) })
  draw(canvas, track, frame, { corners: null, point: 0, lit: 0, ratio: 1, photograph: { picture, x: 10, y: 20, width: 30, height: 40 } })
  const at = calls.findIndex(([name]) => name === 'drawImage')

  expect(calls[at]).toEqual(['drawImage', picture, frame.px(10), frame.py(60), 30 * frame.scale, 40 * frame.scale])
  expect(calls.findLastIndex(([name]) => name === 'fillRect')).toBeGreaterThan(at)
})
