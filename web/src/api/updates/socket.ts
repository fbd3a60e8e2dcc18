// The connection on which the server pushes. Nothing sent on it may wait for a connection.
import { io, type Socket } from 'socket.io-client'

/** Opens the namespace `/ui`; it reconnects automatically, without limit. */
export function openSocket(address = ''): Socket {
  return io(`${address}/ui`, {
    transports: ['websocket'],
    reconnectionDelay: 300,
    reconnectionDelayMax: 2_000,
    randomizationFactor: 0.3,
    timeout: 4_000,
    autoConnect: false,
  })
}

/** Send something now or never; no answer is expected. */
export function say(socket: Socket, event: string, data: object): void {
  if (socket.connected) socket.volatile.emit(event, data)
}

/** Send a request now or never; rejects when there is no answer in time, or no connection. */
export async function askSocket<T>(
  socket: Socket, event: string, data: object, timeout_ms = 4_000,
): Promise<T> {
  if (!socket.connected) throw new Error('no connection')
  return (await socket.volatile.timeout(timeout_ms).emitWithAck(event, data)) as T
}
