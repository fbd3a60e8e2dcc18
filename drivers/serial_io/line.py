"""Lines of text over a serial port: off the event loop, exclusive, with a message when unplugged."""

import asyncio
import contextlib
import re
import threading
from typing import TYPE_CHECKING, Any

from .port import SerialPort

if TYPE_CHECKING:
    from serial import Serial

LOOK_S = 0.1
END_S = 2.0
LONGEST = 4096
"""Bytes of a line; noise without a line end is cut there."""


class SerialLine:
    """Lines out and lines in; a thread reads, so that nothing is lost between calls."""

    def __init__(self, port: SerialPort, ending: bytes = b"\r\n") -> None:
        self.port = port
        self._ending = ending
        self._serial: Serial | None = None
        self._thread: threading.Thread | None = None
        self._lines: asyncio.Queue[str | OSError] = asyncio.Queue()

    @property
    def is_open(self) -> bool:
        """False before `open`, after `close`, and when unplugged."""
        return self._serial is not None and self._thread is not None and self._thread.is_alive()

    async def open(self) -> None:
        """Open the port exclusively; raises OSError with the reason if that fails."""
        from serial import Serial

        await self.close()
        name, framing = self.port.name, self.port.framing
        try:
            self._serial = await asyncio.to_thread(
                Serial, name, timeout=LOOK_S, write_timeout=END_S, exclusive=True, **framing
            )
        except OSError as fault:  # pyserial's own exceptions are OSErrors, too
            raise self.port.why_not(fault) from fault
        self._lines = asyncio.Queue()
        work = (self._serial, asyncio.get_running_loop(), self._lines)
        self._thread = threading.Thread(target=self._listen, args=work, daemon=True)
        self._thread.start()

    async def close(self) -> None:
        """Release the port and wait until its thread has ended."""
        serial, thread = self._serial, self._thread
        self._serial = self._thread = None
        if serial is not None and thread is not None:
            await asyncio.to_thread(thread.join, END_S)
            await asyncio.to_thread(serial.close)

    async def write(self, text: str) -> None:
        """Send a line; raises OSError if the port is gone."""
        if self._serial is None:
            raise self.port.unplugged("it is not open")
        try:
            await asyncio.to_thread(self._serial.write, text.encode("ascii") + self._ending)
        except OSError as fault:
            await self.close()
            raise self.port.unplugged(fault) from fault

    async def read(self, timeout_s: float) -> str | None:
        """The next line, None if none came in time; raises OSError if the port is gone."""
        try:
            async with asyncio.timeout(timeout_s):
                line = await self._lines.get()
        except TimeoutError:
            return None
        if isinstance(line, OSError):
            await self.close()
            raise self.port.unplugged(line) from line
        return line

    async def ask(
        self, text: str, answer: re.Pattern[str], timeout_s: float
    ) -> tuple[re.Match[str] | None, list[str]]:
        """Send a line and wait for a matching one (None if none came); also return all lines received.

        Earlier lines are late answers and lines that do not match are noise: both are skipped.
        """
        now = asyncio.get_running_loop().time
        while not self._lines.empty() and self.is_open:
            self._lines.get_nowait()
        await self.write(text)
        heard: list[str] = []
        until = now() + timeout_s
        while (line := await self.read(max(0.0, until - now()))) is not None:
            heard.append(line)
            if found := answer.fullmatch(line):
                return found, heard
        return None, heard

    def _listen(self, serial: "Serial", loop: Any, lines: "asyncio.Queue[str | OSError]") -> None:
        left = b""
        with contextlib.suppress(RuntimeError):  # the loop has ended, and so has the listener
            while self._serial is serial:
                try:
                    left += serial.read(serial.in_waiting or 1)
                except OSError as fault:
                    loop.call_soon_threadsafe(lines.put_nowait, OSError(str(fault)))
                    return
                *whole, left = left.split(b"\n")
                if len(left) > LONGEST:
                    whole, left = [*whole, left], b""
                for line in whole:
                    text = line.rstrip(b"\r").decode("ascii", "backslashreplace")
                    loop.call_soon_threadsafe(lines.put_nowait, text)
