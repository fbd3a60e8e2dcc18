import { describe, expect, it } from 'vitest'
import { linesOf, sizesOf } from './lines'

describe('lists as people write them', () => {
  it('have one entry per line and no duplicates', () => {
    expect(linesOf(' enclosure closed \n\nsample fixed\nsample fixed')).toEqual(['enclosure closed', 'sample fixed'])
  })

  it('contain step sizes in order, with either decimal sign', () => {
    expect(sizesOf('10 0,1; 1')).toEqual([0.1, 1, 10])
    expect(sizesOf('0.1, 1, 10')).toEqual([0.1, 1, 10])
  })

  it('are refused if an entry is not a size', () => {
    expect([sizesOf(''), sizesOf('0'), sizesOf('101'), sizesOf('a'), sizesOf('-1')]).toEqual([null, null, null, null, null])
  })
})
