import { expect, it } from 'vitest'
import { formOf, kept } from './form'

const known = formOf({ bench: 'LIBS', operators: ['Ada'], step_sizes_mm: [1, 5], by_hand_s: 120, look_every_s: 1, look_for_min: 10, checklists: { laser: ['Lid closed?'], motion: [] } })

it('writes each list on lines of its own', () => {
  expect(known).toEqual({
    bench: 'LIBS', operators: 'Ada', sizes: '1 5', byHand: '120', every: '1', lookFor: '10', checklists: [{ danger: 'laser', lines: 'Lid closed?' }, { danger: 'motion', lines: '' }],
  })
})

it('keeps the edited fields and takes the others when settings arrive', () => {
  const form = { ...known, operators: 'Ada\nBo', lookFor: '5', checklists: [{ danger: 'laser', lines: 'Goggles?' }, { danger: 'motion', lines: '' }] }
  const now = { bench: 'New', operators: 'Cy', sizes: '2', byHand: '600', every: '3', lookFor: '9', checklists: [{ danger: 'laser', lines: 'Key out?' }, { danger: 'motion', lines: 'Clear?' }] }

  expect(kept(form, known, now)).toEqual({
    bench: 'New', operators: 'Ada\nBo', sizes: '2', byHand: '600', every: '3', lookFor: '5', checklists: [{ danger: 'laser', lines: 'Goggles?' }, { danger: 'motion', lines: 'Clear?' }],
  })
})

it('takes a danger that is new and leaves out one that is gone', () => {
  const now = { ...known, checklists: [{ danger: 'heat', lines: 'Cold?' }] }

  expect(kept(known, known, now).checklists).toEqual([{ danger: 'heat', lines: 'Cold?' }])
})
