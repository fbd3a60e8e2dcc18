"""A controller's lines in the binary messages of a WebSocket, as FluidNC has them, like a serial port."""

from .open_port import READ_S, WRITE_S

OPEN_S = 10.0


class WebSocketPort:
    """Text messages (`currentID:1`, `PING`) are FluidNC's own, for its page: they are dropped.

    FluidNC closes an older connection of the same browser session; this one asks for a session of its own.
    """

    in_waiting = 0

    def __init__(self, url: str) -> None:
        from websockets.sync.client import connect

        if "?" not in url:
            url = f"{url.rstrip('/')}/?independent_session=1"
        self._socket = connect(
            url, open_timeout=OPEN_S, close_timeout=WRITE_S, compression=None, proxy=None
        )

    def read(self, size: int) -> bytes:
        """The next message, of any size; empty after 0.1 s. Raises OSError when it was closed."""
        from websockets.exceptions import ConnectionClosed

        try:
            message = self._socket.recv(timeout=READ_S)
        except TimeoutError:
            return b""
        except ConnectionClosed as fault:
            raise OSError(f"the WebSocket was closed: {fault}") from fault
        return message if isinstance(message, bytes) else b""

    def write(self, data: bytes) -> None:
        """Send bytes; raises OSError when it was closed."""
        from websockets.exceptions import ConnectionClosed

        try:
            self._socket.send(data)
        except ConnectionClosed as fault:
            raise OSError(f"the WebSocket was closed: {fault}") from fault

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()
