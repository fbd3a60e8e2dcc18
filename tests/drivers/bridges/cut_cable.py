"""A cable that can be cut: whoever speaks through it loses the connection, and may connect again."""

import contextlib
import socket
import threading
from contextlib import contextmanager


class Cable:
    """Bytes between a driver and its instrument; `cut` ends every connection at once, in its middle."""

    def __init__(self, host, port):
        self._to = (host, port)
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.where = f"127.0.0.1:{self._listener.getsockname()[1]}"
        self._open, self.cuts = set(), 0
        threading.Thread(target=self._accept, daemon=True).start()

    def _accept(self):
        with contextlib.suppress(OSError):
            while True:
                near = self._listener.accept()[0]
                try:
                    far = socket.create_connection(self._to)
                except OSError:
                    near.close()
                    continue
                self._open |= {near, far}
                for one, other in ((near, far), (far, near)):
                    threading.Thread(target=self._carry, args=(one, other), daemon=True).start()

    def _carry(self, one, other):
        with contextlib.suppress(OSError):
            while data := one.recv(65536):
                other.sendall(data)
        for end in (one, other):
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)

    def cut(self):
        """True if there was something to cut."""
        ends, self._open = self._open, set()
        for end in ends:
            with contextlib.suppress(OSError):
                end.shutdown(socket.SHUT_RDWR)
        self.cuts += bool(ends)
        return bool(ends)

    def close(self):
        self._listener.close()
        self.cut()


@contextmanager
def cable(where):
    """A cable to host:port."""
    host, _, port = where.rpartition(":")
    made = Cable(host, int(port))
    try:
        yield made
    finally:
        made.close()
