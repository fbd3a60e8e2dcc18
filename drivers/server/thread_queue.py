"""A thread that does one thing after the other for an event loop.

As an executor of one thread, at half its cost: a goal goes to the ledger's thread twice.
"""

import asyncio
import contextlib
from collections.abc import Callable
from queue import SimpleQueue
from threading import Thread
from typing import Any, TypeVar, TypeVarTuple

Args = TypeVarTuple("Args")
T = TypeVar("T")


class ThreadQueue:
    """The thread ends with the process, or when it is closed."""

    def __init__(self, name: str) -> None:
        self._closed = False
        self._queue: SimpleQueue[tuple[asyncio.Future[Any], Callable[..., Any], Any] | None]
        self._queue = SimpleQueue()
        self._thread = Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def do(self, work: Callable[[*Args], T], *args: *Args) -> asyncio.Future[T]:
        """Do it after everything before it; what is cancelled before it has begun is left out."""
        if self._closed:
            raise RuntimeError(f"{self._thread.name} is closed")
        done: asyncio.Future[T] = asyncio.get_running_loop().create_future()
        self._queue.put((done, work, args))
        return done

    def close(self) -> None:
        """Wait until all is done."""
        self._closed = True
        self._queue.put(None)
        self._thread.join()

    def _run(self) -> None:
        while (queued := self._queue.get()) is not None:
            done, work, args = queued
            if done.cancelled():
                continue
            answer, fault = None, None
            try:
                answer = work(*args)
            except BaseException as raised:  # whatever it is belongs to who waits for it
                fault = raised
            with contextlib.suppress(RuntimeError):  # the loop is closed, and nobody waits
                done.get_loop().call_soon_threadsafe(_settle, done, answer, fault)


def _settle(done: asyncio.Future[Any], answer: Any, fault: BaseException | None) -> None:
    if done.done():
        return
    if fault is None:
        done.set_result(answer)
    else:
        done.set_exception(fault)
