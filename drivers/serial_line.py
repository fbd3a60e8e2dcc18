"""Lines of text over a serial port: off the event loop, nobody else's, unplugged is a sentence."""

import asyncio
import contextlib
import re
import threading
from typing import TYPE_CHECKING, Any

from .serial_port import SerialPort

if TYPE_CHECKING:
    from serial import Serial

LOOK_S = 0.1
END_S = 2.0
LONGEST = 4096
"""Bytes of a line; noise that never ends one is cut there."""


class SerialLine:
    """Lines out and lines in; a thread reads, so that nothing is lost while nobody waits."""

    def __init__(self, port: SerialPort, ending: bytes = b"\r\n") -> None:
        self.port = port
        self._ending = ending
        self._serial: Serial | None = None
        self._thread: threading.Thread | None = None
        self._lines: asyncio.Queue[str | OSError] = asyncio.Queue()

    @property
    def is_open(self) -> bool:
        """False before `open`, after `close`, and once it is unplugged."""
        return self._serial is not None and self._thread is not None and self._thread.is_alive()

    async def open(self) -> None:
        """Take the port for ourselves; raises OSError with a sentence where that cannot be."""
        from serial import Serial

        await self.close()
        name, framing = self.port.name, self.port.framing
        try:
            self._serial = await asyncio.to_thread(
                Serial, name, timeout=LOOK_S, write_timeout=END_S, exclusive=True, **framing
            )
        except OSError as fault:  # pyserial's own faults are OSErrors, too
            raise self.port.why_not(fault) from fault
        self._lines = asyncio.Queue()
        work = (self._serial, asyncio.get_running_loop(), self._lines)
        self._thread = threading.Thread(target=self._listen, args=work, daemon=True)
        self._thread.start()

    async def close(self) -> None:
        """Let go of the port; its thread has ended then."""
        serial, thread = self._serial, self._thread
        self._serial = self._thread = None
        if serial is not None and thread is not None:
            await asyncio.to_thread(thread.join, END_S)
            await asyncio.to_thread(serial.close)

    async def write(self, text: str) -> None:
        """Send a line; raises OSError where the port is gone."""
        if self._serial is None:
            raise self.port.gone("it is not open")
        try:
            await asyncio.to_thread(self._serial.write, text.encode("ascii") + self._ending)
        except OSError as fault:
            await self.close()
            raise self.port.gone(fault) from fault

    async def read(self, timeout_s: float) -> str | None:
        """The next line, None where none came in time; raises OSError where the port is gone."""
        try:
            async with asyncio.timeout(timeout_s):
                line = await self._lines.get()
        except TimeoutError:
            return None
        if isinstance(line, OSError):
            await self.close()
            raise self.port.gone(line) from line
        return line

    async def ask(
        self, text: str, answer: re.Pattern[str], timeout_s: float
    ) -> tuple[re.Match[str] | None, list[str]]:
        """Send a line, and wait for one that fits; None where none came, and all that was heard.

        What came before is late for somebody else, what does not fit is noise: both are passed over.
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
        with contextlib.suppress(RuntimeError):  # the loop has ended, and so has who listened
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
