"""An event loop whose time jumps: when nothing is left to do, the next timer is due at once."""

import asyncio
import selectors
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

LONGEST_REAL_S = 300.0


class StandsStill(RuntimeError):
    """Everything waits and nothing is due: in real time this would wait for ever."""


class VirtualLoop(asyncio.SelectorEventLoop):
    """`time()` starts at 0 and jumps from timer to timer; real threads are waited for on request.

    Every timeout, wait and simulated movement uses the loop's time, so an hour takes only as long
    as the computing in it.
    """

    def __init__(self, longest_real_s: float = LONGEST_REAL_S) -> None:
        """`longest_real_s`: how long a real thread, or a socket, is waited for where nothing is due.

        0: there are none.
        """
        self._leaping = _LeapingSelector(longest_real_s)
        self.in_threads = 0
        """How often something was given to a thread."""
        super().__init__(self._leaping)

    def time(self) -> float:
        """Seconds of virtual time."""
        return self._leaping.now

    def run_in_executor(self, executor: Any, func: Callable[..., Any], *args: Any) -> Any:
        self.in_threads += 1
        return super().run_in_executor(executor, func, *args)

    @contextmanager
    def held(self) -> Iterator[None]:
        """Let no virtual time pass inside: a thread computes something that is due by now."""
        self._leaping.holds += 1
        try:
            yield
        finally:
            self._leaping.holds -= 1


class _LeapingSelector(selectors.DefaultSelector):
    def __init__(self, longest_real_s: float) -> None:
        super().__init__()
        self._longest_real_s = longest_real_s
        self.now = 0.0
        self.holds = 0

    def select(self, timeout: float | None = None):
        ready = super().select(0) if self._longest_real_s else []
        if ready or timeout == 0:
            return ready
        if self.holds or timeout is None:
            ready = super().select(self._longest_real_s)
            while self.holds and not ready:  # a busy computer: the thread computes, and will end
                ready = super().select(self._longest_real_s)
            if not ready:
                raise StandsStill("the rehearsal waits for something that never comes")
            return ready
        self.now += max(0.0, timeout)
        return ready
