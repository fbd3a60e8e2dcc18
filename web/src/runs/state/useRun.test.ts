import { createPinia, setActivePinia } from 'pinia'
import type { Socket } from 'socket.io-client'
import { expect, it, vi } from 'vitest'
import { effectScope } from 'vue'
import { useConnection } from '../../api/updates/connection'
import { useRun } from './useRun'

it('a run whose state did not come in time is asked for again, and then shown', async () => {
  vi.useFakeTimers()
  setActivePinia(createPinia())
  const emitWithAck = vi.fn()
    .mockRejectedValueOnce(new Error('operation has timed out'))
    .mockResolvedValue({ ok: true, text: '', run: { id: 'r1', seq: 1, live: true, loops: [], nodes: {} } })
  const socket = { connected: true, on: vi.fn(), off: vi.fn(), volatile: { emit: vi.fn(), timeout: () => ({ emitWithAck }) } }
  const connection = useConnection()
  vi.spyOn(connection, 'line').mockReturnValue(socket as unknown as Socket)
  connection.bench.seq = 1
  const scope = effectScope()
  const { picture, failure } = scope.run(() => useRun(() => 'r1')) as ReturnType<typeof useRun>
  await vi.advanceTimersByTimeAsync(0)

  expect(failure.value).toContain('asked again')
  expect(picture.value).toBeNull()

  await vi.advanceTimersByTimeAsync(1_000)

  expect(picture.value?.head.id).toBe('r1')
  expect(failure.value).toBe('')

  scope.stop()
  vi.useRealTimers()
})
