"""A thread that does one thing after the other for an event loop.

As an executor of one thread, at a third of its cost: a goal goes to the ledger's thread twice.
"""

import asyncio
import contextlib
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from queue import SimpleQueue
from threading import Lock, Thread
from typing import Any, TypeVar, TypeVarTuple

Args = TypeVarTuple("Args")
T = TypeVar("T")
QUICK_S = 0.001
"""So long the loop waits for quick work: being woken up costs half as much, and a stop can bear it."""
CAN_WAIT = time.get_clock_info("monotonic").resolution < QUICK_S
"""On Windows it would be 16 ms."""


def _closed_gate() -> Any:
    gate = Lock()
    gate.acquire()
    return gate


@dataclass(slots=True)
class _Job:
    """`left`: the loop does not wait for it (any more), so that the thread wakes it up."""

    done: asyncio.Future[Any]
    work: Callable[..., Any]
    args: tuple[Any, ...]
    left: bool
    gate: Any = field(default_factory=_closed_gate)
    is_over: bool = False
    answer: Any = None
    fault: BaseException | None = None

    def pass_on(self) -> None:
        if self.done.done():
            return
        if self.fault is None:
            self.done.set_result(self.answer)
        else:
            self.done.set_exception(self.fault)


class ThreadQueue:
    """The thread ends with the process, or when it is closed."""

    def __init__(self, name: str) -> None:
        self._closed = False
        self._asked = self._ended = 0
        self._is_quick = CAN_WAIT
        self._queue: SimpleQueue[_Job | None] = SimpleQueue()
        self._thread = Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def do(self, work: Callable[[*Args], T], *args: *Args) -> asyncio.Future[T]:
        """Do it after everything before it; what is cancelled before it has begun is left out.

        Where nothing is before it, and the last work took less than QUICK_S, it is waited for as long.
        """
        if self._closed:
            raise RuntimeError(f"{self._thread.name} is closed")
        done: asyncio.Future[T] = asyncio.get_running_loop().create_future()
        alone = self._asked == self._ended
        self._asked += 1
        job = _Job(done, work, args, left=not (alone and self._is_quick))
        self._queue.put(job)
        if not job.left:
            job.left = not job.gate.acquire(timeout=QUICK_S)
            if job.is_over:  # perhaps before the thread saw that it was left
                job.pass_on()
        return done

    def close(self) -> None:
        """Wait until all is done."""
        self._closed = True
        self._queue.put(None)
        self._thread.join()

    def _run(self) -> None:
        while (job := self._queue.get()) is not None:
            began = time.perf_counter()
            if not job.done.cancelled():
                try:
                    job.answer = job.work(*job.args)
                except BaseException as raised:  # whatever it is belongs to who waits for it
                    job.fault = raised
            self._is_quick = CAN_WAIT and time.perf_counter() - began < QUICK_S
            self._ended += 1
            job.is_over = True
            job.gate.release()
            if job.left:
                with contextlib.suppress(RuntimeError):  # the loop is closed, and nobody waits
                    job.done.get_loop().call_soon_threadsafe(job.pass_on)
