"""The run's own time: it stands still while the run is paused."""

import time


class RunClock:
    """Seconds since the start, pauses not counted; every timeout and wait of a run goes by it."""

    def __init__(self) -> None:
        self._offset = time.monotonic()
        self._paused_at: float | None = None

    def now(self) -> float:
        """Seconds of running time."""
        return (self._paused_at or time.monotonic()) - self._offset

    def pause(self) -> None:
        """Stand still."""
        self._paused_at = self._paused_at or time.monotonic()

    def go_on(self) -> None:
        """Run again from where it stood."""
        if self._paused_at is not None:
            self._offset += time.monotonic() - self._paused_at
            self._paused_at = None
