"""An exclusive serial port: the event loop never waits for it.

Where the system tells a port's readiness (Linux, macOS), the loop itself reads what is there and writes
what finds room, which spares a change of threads each; what finds no room, and all else, is for threads.
"""

import asyncio
import contextlib
import errno
import logging
import os
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any

READ_S = 0.1
WRITE_S = 2.0
CLOSE_S = 2.0
READ_BYTES = 4096
LOG = logging.getLogger("labrun")


class OpenPort:
    """One port, opened by `opened`. `take` gets incoming bytes, `lost` the fault when it is gone.

    Both are called in the event loop. The port is locked, so that no second program can open it.
    """

    def __init__(
        self, name: str, opened: Callable[[], Any], take: Callable[[bytes], None],
        lost: Callable[[Exception], None],
    ) -> None:  # fmt: skip
        self.name = name
        self._opened = opened
        self._take = take
        self._lost = lost
        self._serial: Any = None
        self._closing = threading.Event()
        self._reader: threading.Thread | None = None
        self._writer: ThreadPoolExecutor | None = None
        self._queued: Future[Any] | None = None
        self._descriptor: int | None = None

    @property
    def is_open(self) -> bool:
        """False before `open`, after `close`, and when unplugged."""
        return self._serial is not None and not self._closing.is_set()

    async def open(self) -> None:
        """Open and lock it; raises OSError with the reason."""
        await self.close()
        self._loop = asyncio.get_running_loop()
        self._serial = await asyncio.to_thread(self._opened)
        self._closing.clear()
        self._writer = ThreadPoolExecutor(1, thread_name_prefix=f"write {self.name}")
        self._queued, self._descriptor = None, self._watched()
        if self._descriptor is None:
            self._reader = threading.Thread(
                target=self._read, name=f"read {self.name}", daemon=True
            )
            self._reader.start()

    def write(self, data: bytes) -> None:
        """Send bytes, in order, or queue them; a failure is reported through `lost`."""
        if self._writer is None:
            return
        try:
            rest = self._written_at_once(data)
        except OSError as fault:
            self._tell_lost(fault)
            return
        if rest:
            self._queued = self._writer.submit(self._write, rest)

    async def send(self, data: bytes) -> None:
        """Send bytes, and wait until the system has them; raises OSError."""
        if self._writer is None:
            raise OSError("it is not open")
        if rest := self._written_at_once(data):
            self._queued = self._writer.submit(self._serial.write, rest)
            await asyncio.wrap_future(self._queued)

    async def close(self) -> None:
        """Release the port; queued bytes are sent first."""
        self._unwatch()
        writer, self._writer = self._writer, None  # who writes meanwhile finds it closed
        await asyncio.to_thread(self._close, writer)

    def _watched(self) -> int | None:
        """The descriptor of a port that the loop reads by itself."""
        if os.name != "posix" or not hasattr(self._serial, "fileno"):
            return None
        try:
            descriptor = self._serial.fileno()
            self._loop.add_reader(descriptor, self._read_at_once, descriptor)
        except (NotImplementedError, OSError):  # this loop, or its way of waiting, cannot
            return None
        return descriptor

    def _unwatch(self) -> None:
        if self._descriptor is not None:
            self._loop.remove_reader(self._descriptor)
            self._descriptor = None

    def _read_at_once(self, descriptor: int) -> None:
        try:
            data = b"" if self._closing.is_set() else os.read(descriptor, READ_BYTES)
            if not data:
                raise OSError("readiness to read, but there was nothing")
        except BlockingIOError:
            return
        except OSError as fault:
            self._unwatch()
            self._tell_lost(fault)
        else:
            self._take(data)

    def _written_at_once(self, data: bytes) -> bytes:
        """Write what finds room without waiting; returns the rest. Raises OSError."""
        if self._descriptor is None or (self._queued is not None and not self._queued.done()):
            return data
        try:
            return data[os.write(self._descriptor, data) :]
        except BlockingIOError:
            return data

    def _write(self, data: bytes) -> None:
        try:
            self._serial.write(data)
        except Exception as fault:  # a port that is gone raises what the system likes
            self._tell_lost(fault)

    def _read(self) -> None:
        while not self._closing.is_set():
            try:
                data = self._serial.read(self._serial.in_waiting or 1)
            except Exception as fault:  # as above
                self._tell_lost(fault)
                return
            if data:
                self._call(self._take, data)

    def _tell_lost(self, fault: Exception) -> None:
        if not self._closing.is_set():
            self._closing.set()
            if not isinstance(fault, OSError):
                LOG.error("%s is taken for lost", self.name, exc_info=fault)
            self._call(self._lost, fault)

    def _call(self, function: Callable[..., None], *arguments: Any) -> None:
        with contextlib.suppress(RuntimeError):  # the loop has ended before us
            self._loop.call_soon_threadsafe(function, *arguments)

    def _close(self, writer: ThreadPoolExecutor | None) -> None:
        if writer is not None:
            writer.shutdown(wait=True)  # bounded by the port's own write timeout
        self._closing.set()
        if self._reader is not None:
            self._reader.join(CLOSE_S)
            self._reader = None
        if self._serial is not None:
            with contextlib.suppress(OSError):  # it may be gone already
                self._serial.close()
            self._serial = None


def open_exclusively(name: str, **framing: Any) -> Any:
    """The open port, locked for other programs; raises OSError with the reason."""
    from serial import Serial

    try:
        return Serial(name, timeout=READ_S, write_timeout=WRITE_S, exclusive=True, **framing)
    except (OSError, ValueError) as fault:  # pyserial's own exceptions are OSErrors, too
        raise OSError(_why_not(name, getattr(fault, "errno", None), str(fault))) from fault


def _why_not(name: str, number: int | None, said: str) -> str:
    if number == errno.ENOENT or (number is None and "FileNotFoundError" in said):
        return f"there is no port {name}: is the cable plugged in? {_others()}"
    if number == errno.EACCES and not _is_windows_name(name):
        return (
            f"this user may not open {name}: `sudo usermod -aG dialout $USER` allows it "
            f"after the next login"
        )
    if number in (errno.EAGAIN, errno.EBUSY, errno.EWOULDBLOCK) or "PermissionError" in said:
        return f"{name} is in use by another program: close it there; only one program at a time can use it"
    if number in (errno.ENOTTY, errno.EINVAL) or (number is None and "configure" in said):
        return f"{name} is not a serial port ({said}). {_others()}"
    return f"{name} cannot be opened: {said}"


def _is_windows_name(name: str) -> bool:
    return name.upper().startswith("COM") and not Path(name).exists()


def _others() -> str:
    """The available ports, so that the right one can be copied from the message."""
    from serial.tools.list_ports import comports

    found = [f"{port.device} ({port.description})" for port in comports()]
    return f"Available: {', '.join(found)}" if found else "This computer has no serial port now"
