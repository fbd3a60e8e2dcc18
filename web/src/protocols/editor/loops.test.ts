// Loops as forms: what is read from an expression, and what is written.
import { describe, expect, test } from 'vitest'
import { callOf, innerOf, itemsOf } from '../text/calls'
import { countOf, fresh, keyOf, loopOf, writtenLoop, type LoopKind } from './loops'

describe('a call', () => {
  test('is taken apart at its own commas', () => {
    expect(callOf("grid(x=span(0, 4 mm, 1 mm), y=[1, 2], order='a,(b')")).toEqual({
      name: 'grid', args: [{ key: 'x', text: 'span(0, 4 mm, 1 mm)' }, { key: 'y', text: '[1, 2]' }, { key: 'order', text: "'a,(b'" }],
    })
    expect(itemsOf('[20 mm]')).toEqual(['20 mm'])
  })

  test('is not what is more, or less, than one call', () => {
    for (const text of ['span(0, 1, 1) + span(2, 3, 1)', 'a', 'f(', 'f(]', '(f())', 'f() if x else g()']) expect(callOf(text), text).toBe(null)
    expect(innerOf('${{ a }} and ${{ b }}')).toBe(null)
  })

  test('may compare, which names no argument', () => {
    expect(callOf('f(a == b)')?.args).toEqual([{ key: '', text: 'a == b' }])
  })
})

const SAME = [
  "${{ grid(x=span(10 mm, 14 mm, 0.2 mm), y=span(0 mm, 10 mm, 0.2 mm), order='snake') }}",
  "${{ grid(x=span(0, params.width, params.pitch), y=span(0, params.height, params.pitch), order='columns') }}",
  '${{ grid(x=span(0 mm, 4 mm, 1 mm), y=span(0 mm, 10 mm, 2 mm)) }}',
  '${{ inside(grid(x=span(0 mm, 4 mm, 1 mm), y=span(0 mm, 10 mm, 2 mm)), steps.look.samples[0].outline, 1 mm) }}',
  "${{ grid(x=span(0 mm, 1 mm, 0.3 mm, fit='inside'), y=span(0 mm, 2 mm, 1 mm)) }}",
  '${{ grid(x=linspace(10 mm, 40 mm, 4), y=[20 mm]) }}',
  '${{ grid(x=[5 mm], y=linspace(0 mm, 9 mm, 10)) }}',
  '${{ grid(x=span(100 mm, 199 mm, 9 mm), y=span(143 mm, 80 mm, -9 mm)) }}',
  '${{ span(10 mm, 10.8 mm, 0.1 mm) }}', "${{ csv('samples.csv') }}",
]

test('what a form reads, it writes as it was', () => {
  for (const text of SAME) {
    const loop = loopOf(text)
    expect(loop && writtenLoop(loop), text).toBe(text)
  }
  expect(loopOf(['Li', 'K'])).toEqual({ kind: 'list', slots: {}, items: ['Li', 'K'] })
})

test('anything else stays an expression', () => {
  for (const text of ['${{ range(3) }}', '${{ params.volumes }}', "${{ csv('a.csv', x='mm') }}", '${{ grid(x=span(0, 1, 1), y=span(0, 1, 1), order=params.order) }}', '${{ grid(a, b, c, d) }}', 3, [{ x: 1 }]]) {
    expect(loopOf(text), String(text)).toBe(null)
  }
})

test('a plate is a grid of the standard’s pitch, with A1 at the back', () => {
  const plate = loopOf(SAME[7])

  expect(plate).toEqual({ kind: 'plate', slots: { wells: '96', x0: '100 mm', y0: '143 mm', order: 'rows' } })
  expect(plate && keyOf(plate, 'well')).toBe("${{ 'ABCDEFGH'[well.iy] }}${{ well.ix + 1 }}")
})

test('a pitch that does not divide the area says where the points end, and is written to fit', () => {
  const loop = { kind: 'grid' as LoopKind, slots: { x0: '10 mm', x1: '1.1 cm', y0: '0 mm', y1: '2 mm', px: '0.3 mm', py: '0.5 mm', order: 'rows' } }

  expect(countOf(loop)).toBe('4 × 5 = 20 points; the last x is 10.9 mm')
  expect(writtenLoop(loop)).toBe("${{ grid(x=span(10 mm, 1.1 cm, 0.3 mm, fit='inside'), y=span(0 mm, 2 mm, 0.5 mm)) }}")
  expect(countOf({ kind: 'grid', slots: { ...loop.slots, x1: 'params.width' } })).toBe('')
})

test('every form begins with something that it can read', () => {
  for (const kind of ['grid', 'line', 'plate', 'values', 'list', 'table'] as const) {
    expect(loopOf(writtenLoop(fresh(kind)))?.kind).toBe(kind)
    expect(loopOf(writtenLoop(fresh(kind, loopOf(SAME[0]))))?.kind).toBe(kind)
  }
})
