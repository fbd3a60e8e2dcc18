"""The run's own time: it stops while the run is paused."""

import time
from collections.abc import Callable


class RunClock:
    """Seconds since the start, pauses not counted; every timeout and wait of a run uses it."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._offset = clock()
        self._paused_at: float | None = None

    def now(self) -> float:
        """Seconds of running time."""
        return (self._clock() if self._paused_at is None else self._paused_at) - self._offset

    def pause(self) -> None:
        """Stop the clock."""
        if self._paused_at is None:
            self._paused_at = self._clock()

    def go_on(self) -> None:
        """Continue from where it stopped."""
        if self._paused_at is not None:
            self._offset += self._clock() - self._paused_at
            self._paused_at = None
