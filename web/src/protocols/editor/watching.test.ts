// What happens when a watched condition holds: read and written.
import { expect, test } from 'vitest'
import { WAYS, wayOf, writtenWay } from './watching'

test('each way is read as it was written', () => {
  for (const [way] of WAYS) expect(wayOf(writtenWay(way, 'too hot')), way).toEqual({ way, text: way === 'pause' ? '' : 'too hot' })
  expect(wayOf([{ fail: 'leak' }])).toEqual({ way: 'fail', text: 'leak' })
})

test('anything else stays as it is written', () => {
  for (const then of [
    undefined, [], [{ do: 'pump.stop' }, { fail: 'leak' }], { fail: 'leak', name: 'Leak' }, [{ notify: 'a' }, { fail: 'b' }], [{ fail: 'a' }, { notify: 'a' }], { fail: 3 },
    [{ notify: 'a' }, { fail: 'a' }, { log: 'a' }],
  ]) expect(wayOf(then), JSON.stringify(then)).toBe(null)
})
