"""An instrument at the other end of an emulated serial line: a pseudo-terminal and a function.

For tests on Linux and macOS; Windows has no pseudo-terminals.
"""

import asyncio
import contextlib
import os
import threading
from collections.abc import Awaitable, Callable
from pathlib import Path

from ...system import tasks


class PtyPeer:
    """`answer(line)` is awaited for each incoming line, several at a time; "" sends no answer.

    Its exceptions are raised at the end of the block. The port is a symbolic link at `link`. `begin`
    and `end` run before the first line and after the last one, in the same loop as `answer`.
    """

    def __init__(
        self,
        link: Path,
        answer: Callable[[str], Awaitable[str]],
        begin: Callable[[], Awaitable[None]] | None = None,
        end: Callable[[], Awaitable[None]] | None = None,
    ) -> None:
        self.port = str(link)
        self._link, self._answer, self._begin, self._end = link, answer, begin, end
        self._ready = threading.Event()
        self._faults: list[BaseException] = []
        self._over: asyncio.Event
        self._loop: asyncio.AbstractEventLoop
        self._thread = threading.Thread(target=lambda: asyncio.run(self._live()), daemon=True)

    def __enter__(self) -> "PtyPeer":
        self._thread.start()
        if not self._ready.wait(10):
            raise TimeoutError(f"no response on {self.port}")
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(RuntimeError):  # it ended by itself
            self._loop.call_soon_threadsafe(self._over.set)
        self._thread.join(10)
        if self._faults:
            raise self._faults[0]

    async def _live(self) -> None:
        import tty

        self._loop, self._over = asyncio.get_running_loop(), asyncio.Event()
        master, slave = os.openpty()
        tty.setraw(slave)
        self._link.unlink(missing_ok=True)
        self._link.symlink_to(os.ttyname(slave))
        answering: set[asyncio.Task[None]] = set()
        left = b""

        def hear() -> None:
            nonlocal left
            *lines, left = (left + os.read(master, 65536)).split(b"\n")
            for line in lines:
                said = line.rstrip(b"\r").decode()
                answering.add(tasks.spawn(f"answering {said}", self._say(master, said)))

        if self._begin is not None:
            await self._begin()
        self._loop.add_reader(master, hear)
        self._ready.set()
        await self._over.wait()
        self._loop.remove_reader(master)
        await tasks.end(*answering)
        if self._end is not None:
            await self._end()
        for terminal in (master, slave):  # the slave stays open, or a closed port would hang up
            os.close(terminal)

    async def _say(self, master: int, line: str) -> None:
        try:
            answer = await self._answer(line)
        except Exception as fault:  # it is raised again at the end of the block
            self._faults.append(fault)
            answer = f"{type(fault).__name__}: {fault}"
        if answer:
            await asyncio.to_thread(os.write, master, answer.encode() + b"\r\n")
