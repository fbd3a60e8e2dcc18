// The grid as two corners: which parameters they are, and what dragging and teaching write.
import { expect, test } from 'vitest'
import { parse } from 'yaml'
import { cornersOf, moveTo, stretchTo } from './gridding'

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
  expect(cornersOf(data, ['steps', 0])).toEqual({
    origin: { x: 'x0', y: 'y0' }, size: { x: 'width', y: 'height' }, params: ['x0', 'y0', 'width', 'height', 'pitch'],
    at: { x: 10, y: 2, width: 4, height: 10 },
  })
  expect(cornersOf(data, ['steps', 1])).toBe(null)
})

test('moving the start corner writes the start, moving the other one whole steps of the pitch', () => {
  const corners = cornersOf(data, ['steps', 0])
  if (!corners) throw new Error('no corners')

  expect(moveTo(corners, 12.34567, 5)).toEqual([
    { kind: 'set', path: ['params', 'x0', 'default'], value: '12.346 mm' }, { kind: 'set', path: ['params', 'y0', 'default'], value: '5 mm' },
  ])
  expect(stretchTo(data, corners, 12.29, 2.01).map((one) => (one.kind === 'set' ? one.value : null))).toEqual(['2.2 mm', '0.2 mm'])
})
