"""Output that holds nobody up, however long its reader takes."""

import errno
import os
import queue
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO, cast

from . import WINDOWS


def reader_is_gone(fault: BaseException) -> bool:
    """Whether it says that nobody reads any more, as behind `| head`.

    Windows tells of a pipe that is closed as an invalid argument (CPython's issue 79935).
    """
    if WINDOWS and isinstance(fault, OSError) and fault.errno == errno.EINVAL:
        return fault.filename is None
    return isinstance(fault, BrokenPipeError)


@contextmanager
def read_or_not() -> Iterator[None]:
    """Within, a reader that has gone, as behind `| head`, ends what is printed, and is no failure."""
    try:
        yield
        sys.stdout.flush()
    except OSError as fault:
        if not reader_is_gone(fault):
            raise
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


class Unhurried:
    """A text stream whose `write` returns at once; a thread passes on what was written, in order.

    What is not read yet is kept in memory. Once its reader has gone, `write` raises that OSError.
    """

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._fault: OSError | None = None
        self._waiting: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._pass_on, name="output", daemon=True)
        self._thread.start()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._out, name)

    def write(self, text: str) -> int:
        if not isinstance(text, str):
            raise TypeError(f"a text is written here, not {type(text).__name__}")
        if self._fault is not None:
            raise self._fault
        self._waiting.put(text)
        return len(text)

    def flush(self) -> None:
        """Nothing to do: what was written is passed on as soon as it is taken."""

    def finish(self) -> None:
        """Wait until everything has been taken, or nobody is there to take it."""
        self._waiting.put(None)
        self._thread.join()

    def _pass_on(self) -> None:
        try:
            while (text := self._waiting.get()) is not None:
                self._out.write(text)
                self._out.flush()
        except OSError as fault:
            self._fault = fault


@contextmanager
def unhurried_stdout() -> Iterator[None]:
    """While this lasts, nothing that prints waits for a full pipe, or a terminal that was halted.

    Ctrl-S, a pager and a click into a Windows console all halt whoever writes there. At its end
    everything has been taken.
    """
    before = sys.stdout
    out = Unhurried(before)
    sys.stdout = cast("TextIO", out)
    try:
        yield
    finally:
        sys.stdout = before
        out.finish()
