import { expect, test } from 'vitest'
import type { RunDetail } from '../../api/types'
import { RunPicture } from '../picture'
import { stepStatus } from './stepStatus'

const step = (path: string, parent: string | null, kind: string, loop = false) => ({ path, parent, kind, loop, depth: 0, title: path })
const OUTLINE = [
  step('main/ready', null, 'do'), step('main/go_ahead', null, 'confirm'), step('main/sum', null, 'set'),
  step('main/group', null, 'steps'), step('main/group/scan', 'main/group', 'foreach', true), step('main/group/scan/*/shoot', 'main/group/scan', 'do'),
  step('main/end', null, 'do'),
]

function run(live: boolean, nodes: Record<string, string>, current: string | null, fate = live ? 'running' : 'failed'): RunPicture {
  const told = Object.fromEntries(Object.entries(nodes).map(([path, status]) => [path, { status }]))
  const loops = [{ path: 'main/group/scan', current }]
  return new RunPicture({ id: 'r', seq: 0, live, fate, nodes: told, loops, under_way: [], outline: OUTLINE } as unknown as RunDetail)
}
function says(picture: RunPicture): string[] {
  return picture.detail.outline.map((one) => {
    const { status, words } = stepStatus(one, picture)
    return `${status ?? '-'} ${words}`.trim()
  })
}

test('around what is under way everything is running', () => {
  const picture = run(true, { 'main/ready': 'ok', 'main/go_ahead': 'skipped', 'main/group/scan/*/shoot': 'ok', 'main/group/scan': 'waiting' }, '3,0')

  expect(says(picture)).toEqual(['ok', 'skipped', 'waiting', 'running', 'running', 'ok', 'waiting'])
})

test('a finished run shows what it never reached, except steps that leave no record', () => {
  const picture = run(false, { 'main/ready': 'failed' }, null)

  expect(says(picture)).toEqual(['failed', '- not run', '-', '-', '-', '- not run', '- not run'])
})

test('a loop within a loop of a run that succeeded is done, though nothing records its end', () => {
  const picture = run(false, { 'main/group/scan': 'waiting', 'main/group/scan/*/shoot': 'ok' }, null, 'succeeded')

  expect(says(picture)[4]).toBe('ok')
})

test('nothing of an aborted run waits or runs while its report is written', () => {
  const picture = run(true, { 'main/ready': 'ok', 'main/go_ahead': 'ok', 'main/group/scan': 'waiting' }, null, 'aborted')

  expect(says(picture)).toEqual(['ok', 'ok', '-', '-', '- not finished', '- not run', '- not run'])
})
