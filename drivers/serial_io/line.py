"""Lines of text over a serial port: off the event loop, exclusive, with a message when unplugged."""

import asyncio
import re

from .open_port import OpenPort
from .port import SerialPort

LONGEST = 4096
"""Bytes of a line; noise without a line end is cut there."""


class SerialLine:
    """Lines out and lines in; what comes between calls is kept."""

    def __init__(self, port: SerialPort, ending: bytes = b"\r\n") -> None:
        self.port = port
        self._ending = ending
        self._bytes = OpenPort(port.name, port.opened, self._take, self._lost)
        self._left = b""
        self._lines: asyncio.Queue[str | Exception] = asyncio.Queue()

    @property
    def is_open(self) -> bool:
        """False before `open`, after `close`, and when unplugged."""
        return self._bytes.is_open

    async def open(self) -> None:
        """Open the port exclusively; raises OSError with the reason if that fails."""
        await self.close()
        self._left, self._lines = b"", asyncio.Queue()
        await self._bytes.open()

    async def close(self) -> None:
        """Release the port and wait until its thread has ended."""
        await self._bytes.close()

    async def write(self, text: str) -> None:
        """Send a line; raises OSError if the port is gone."""
        try:
            await self._bytes.send(text.encode("ascii") + self._ending)
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
        if isinstance(line, Exception):
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

    def _take(self, data: bytes) -> None:
        *whole, self._left = (self._left + data).split(b"\n")
        if len(self._left) > LONGEST:
            whole, self._left = [*whole, self._left], b""
        for line in whole:
            self._lines.put_nowait(line.rstrip(b"\r").decode("ascii", "backslashreplace"))

    def _lost(self, fault: Exception) -> None:
        self._lines.put_nowait(fault)
