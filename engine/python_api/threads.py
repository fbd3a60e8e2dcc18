"""Work in a thread of its own: in a notebook a loop is running where the cells are."""

import time
from collections.abc import Callable
from concurrent.futures import Future
from threading import Thread
from typing import Generic, TypeVar

T = TypeVar("T")
POLL_S = 0.2
"""How soon Ctrl-C is heard while somebody waits: on Windows a wait without an end is deaf to it."""


class Work(Thread, Generic[T]):
    """Work that has begun in a thread; a program's end does not wait for it."""

    def __init__(self, name: str, work: Callable[[], T]) -> None:
        super().__init__(name=name, daemon=True)
        self._work = work
        self.ended: Future[T] = Future()
        self.start()

    def run(self) -> None:
        """Do it; what it returns or raises is in `ended`."""
        try:
            self.ended.set_result(self._work())
        except BaseException as fault:  # raised to whoever waits
            self.ended.set_exception(fault)


def result(
    ended: "Future[T]",
    timeout: float | None = None,
    interrupted: Callable[[], object] | None = None,
) -> T:
    """What work returned, or raise what it raised; TimeoutError while it goes on after `timeout` s.

    Ctrl-C calls `interrupted` and is waited on; without that, the work is left to end by itself.
    """
    until = None if timeout is None else time.monotonic() + timeout
    while not ended.done():
        try:
            ended.exception(POLL_S)
        except TimeoutError:
            if until is not None and time.monotonic() >= until and not ended.done():
                raise
        except KeyboardInterrupt:
            if interrupted is None:
                raise
            interrupted()
    return ended.result()
