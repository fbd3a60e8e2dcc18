"""Lines typed at a terminal, told to an event loop."""

import asyncio
import os
import threading
from collections.abc import Callable

from . import WINDOWS

CHUNK = 4096


class Keyboard:
    """Reads a terminal while it is open; `take` gets each line, without its end, in the loop."""

    def __init__(self, terminal: int, take: Callable[[str], None]) -> None:
        self._terminal = terminal
        self._take = take
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None
        self._is_open = False
        self._rest = b""

    def open(self) -> None:
        """Begin to listen, if it does not yet; what is typed meanwhile waits for the next line's end."""
        if self._is_open:
            return
        self._is_open, self._loop = True, asyncio.get_running_loop()
        if not WINDOWS:
            self._loop.add_reader(self._terminal, self._readable)
        elif (
            self._thread is None
        ):  # no loop can wait for a console, and a read cannot be called off
            self._thread = threading.Thread(target=self._read, name="keyboard", daemon=True)
            self._thread.start()

    def close(self) -> None:
        """Stop listening: lines that are typed from now on are nobody's."""
        if self._is_open and not WINDOWS and self._loop is not None:
            self._loop.remove_reader(self._terminal)
        self._is_open = False

    def _readable(self) -> None:
        self._took(_typed(self._terminal))

    def _read(self) -> None:
        assert self._loop is not None
        while not self._loop.is_closed():
            typed = _typed(self._terminal)
            if self._loop.is_closed():
                return
            self._loop.call_soon_threadsafe(self._took, typed)
            if not typed:
                return

    def _took(self, typed: bytes) -> None:
        if not typed:  # the terminal is gone
            self.close()
        *lines, self._rest = (self._rest + typed).split(b"\n")
        for line in lines:
            if self._is_open:
                self._take(line.decode(errors="replace").rstrip("\r"))


def _typed(terminal: int) -> bytes:
    try:
        return os.read(terminal, CHUNK)
    except OSError:
        return b""
