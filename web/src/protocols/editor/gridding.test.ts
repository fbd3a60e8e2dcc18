// The grid as two corners: which parameters they are, and what dragging and teaching write.
import { expect, test } from 'vitest'
import { parse } from 'yaml'
import { frameOf, zoomed } from './drawing'
import { cornersOf, cutAround, cutOff, moveTo, stretchTo } from './gridding'

const data: unknown = parse(`params:
  x0: {default: 1 cm}
  y0: {default: 2 mm}
  width: {default: 4 mm}
  height: {default: 10 mm}
  pitch: {default: 0.2 mm}
steps:
  - foreach: {point: "\${{ grid(x=span(0, params.width, params.pitch), y=span(0, params.height, params.pitch), order='snake') }}"}
    steps:
      - do: gantry.move_to
        with: {x: "\${{ params.x0 + point.x }}", y: "\${{ point.y + params.y0 }}"}
  - foreach: {i: "\${{ range(3) }}"}
    steps: [{wait: 1 s}]
`)

test('the corners are parameters, in mm whatever their unit', () => {
  expect(cornersOf(data, ['steps', 0])).toMatchObject({ params: ['x0', 'y0', 'width', 'height', 'pitch'], at: { x: 10, y: 2, width: 4, height: 10 } })
  expect(cornersOf(data, ['steps', 1])).toBe(null)
})

test('moving the start corner writes the start, moving the other one whole steps of the pitch', () => {
  const corners = cornersOf(data, ['steps', 0])
  if (!corners) throw new Error('no corners')

  expect(moveTo(corners, 12.34567, 5)).toEqual([
    { kind: 'set', path: ['params', 'x0', 'default'], value: '12.346 mm' }, { kind: 'set', path: ['params', 'y0', 'default'], value: '5 mm' },
  ])
  const written = (x: number, y: number): unknown => stretchTo(corners, x, y).map((one) => (one.kind === 'set' ? one.value : null))

  expect(written(12.29, 2.01)).toEqual(['2.2 mm', '0.2 mm'])
  expect(written(5.75, 1)).toEqual(['5.8 mm', '1 mm', '4.2 mm', '1 mm'])
})

function loop(words: string): unknown {
  return { steps: [{ foreach: { point: words }, steps: [{ do: 'gantry.move_to', with: { x: '${{ point.x }}', y: '${{ point.y }}' } }] }] }
}
function edited(words: string, how: (corners: NonNullable<ReturnType<typeof cornersOf>>) => unknown): unknown {
  const corners = cornersOf(loop(words), ['steps', 0])
  return corners && how(corners)
}
const GRID = "${{ grid(x=span(10 mm, 14 mm, 2 mm), y=span(0 mm, 10 mm, 5 mm), order='snake') }}"

test('the corners of a grid that holds its own lengths are written into it, by whole steps', () => {
  const set = (value: string): unknown => [{ kind: 'set', path: ['steps', 0, 'foreach', 'point'], value }]

  expect(edited(GRID, (one) => one.at)).toEqual({ x: 10, y: 0, width: 4, height: 10 })
  expect(edited(GRID, (one) => moveTo(one, 100, 50))).toEqual(set("${{ grid(x=span(100 mm, 104 mm, 2 mm), y=span(50 mm, 60 mm, 5 mm), order='snake') }}"))
  expect(edited(GRID, (one) => stretchTo(one, 17.2, 21))).toEqual(set("${{ grid(x=span(10 mm, 18 mm, 2 mm), y=span(0 mm, 20 mm, 5 mm), order='snake') }}"))
  expect(edited(GRID, (one) => stretchTo(one, 3.2, -11))).toEqual(set("${{ grid(x=span(4 mm, 10 mm, 2 mm), y=span(-10 mm, 0 mm, 5 mm), order='snake') }}"))
  expect(edited(GRID.replace('0 mm, 10 mm, 5 mm', '10 mm, 0 mm, -5 mm'), (one) => one.to({ x: 30, y: 40, width: 9, height: 11 }, 'both'))).toEqual(set("${{ grid(x=span(30 mm, 38 mm, 2 mm), y=span(50 mm, 40 mm, -5 mm), order='snake') }}"))
  expect(edited(GRID, (one) => one.to({ x: 30, y: 40, width: 9, height: 10 }, 'origin'))).toEqual(set("${{ grid(x=span(30 mm, 39 mm, 2 mm, fit='inside'), y=span(40 mm, 50 mm, 5 mm), order='snake') }}"))
  expect(edited(GRID, (one) => one.to({ x: 30, y: 40, width: 9, height: 11 }, 'both'))).toEqual(set("${{ grid(x=span(30 mm, 38 mm, 2 mm), y=span(40 mm, 50 mm, 5 mm), order='snake') }}"))
})

test('a line follows the longer side of what is drawn or taught, a plate keeps its size', () => {
  expect(edited('${{ grid(x=linspace(10 mm, 40 mm, 4), y=[20 mm]) }}', (one) => stretchTo(one, 9, -30))).toMatchObject([{ value: '${{ grid(x=[10 mm], y=linspace(-30 mm, 20 mm, 4)) }}' }])

  const to = (words: string): unknown => edited(words, (one) => one.to({ x: 30, y: 40, width: 9, height: 63 }, 'both'))

  expect(to('${{ grid(x=linspace(10 mm, 40 mm, 4), y=[20 mm]) }}')).toMatchObject([{ value: '${{ grid(x=[30 mm], y=linspace(40 mm, 103 mm, 4)) }}' }])
  expect(to('${{ grid(x=span(100 mm, 199 mm, 9 mm), y=span(143 mm, 80 mm, -9 mm)) }}')).toMatchObject([{ value: '${{ grid(x=span(30 mm, 129 mm, 9 mm), y=span(103 mm, 40 mm, -9 mm)) }}' }])
})

test('what begins somewhere that is not known has no corners', () => {
  expect(edited(GRID.replace('10 mm', 'params.x0'), (one) => one)).toBe(null)
  expect(cornersOf({ steps: [{ foreach: { point: GRID }, steps: [{ log: '${{ params.x0 + point.x }}' }] }] }, ['steps', 0])).toBe(null)
})

test('what lies beyond the bounds is cut off', () => {
  const bounds = { x0: 0, x1: 730, y0: 0, y1: null }

  expect(cutOff({ x: -10, y: 5, width: 20, height: 30 }, bounds)).toEqual({ x: 0, y: 5, width: 10, height: 30 })
  expect(cutOff({ x: 800, y: -50, width: 20, height: 30 }, bounds)).toBe(null)
})

test('is cut off beside what is kept out, on the side that leaves the most', () => {
  const box = { x: 0, y: 0, width: 100, height: 50 }

  expect(cutAround(box, { x0: 70, x1: 120, y0: null, y1: null })).toEqual({ x: 0, y: 0, width: 70, height: 50 })
  expect(cutAround(box, { x0: -5, x1: 10, y0: 20, y1: 60 })).toEqual({ x: 10, y: 0, width: 90, height: 50 })
  expect(cutAround(box, { x0: -5, x1: 105, y0: null, y1: null })).toBe(null)
})

test('a place that the wheel brings nearer stays where it is, down to a millimetre across', () => {
  const track = { area: { x0: 0, x1: 730, y0: 0, y1: 810 }, x_mm: [], y_mm: [] } as unknown as Parameters<typeof frameOf>[0]
  let frame = frameOf(track, 600, 280, 'bench')
  const at = { x: 500, y: 200 }
  const [px, py] = [frame.px(at.x), frame.py(at.y)]
  for (let i = 0; i < 60; i++) frame = frameOf(track, 600, 280, zoomed(frame, at, 0.8))

  expect([frame.px(at.x), frame.py(at.y)].map(Math.round)).toEqual([px, py].map(Math.round))
  expect((280 - 68) / frame.scale).toBeCloseTo(1)
})
