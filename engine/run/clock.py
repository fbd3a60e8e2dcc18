"""The run's own time, which stops while the run is paused; and the time of day."""

import time
from collections.abc import Callable
from datetime import datetime, timedelta

STEADY = getattr(time, "CLOCK_BOOTTIME", getattr(time, "CLOCK_MONOTONIC", None))
"""Nobody sets it, and it goes on while the computer sleeps."""


def time_of_day() -> datetime:
    """Now, by this computer's clock, with its offset from UTC."""
    return datetime.now().astimezone()


def steady() -> float:
    """Seconds that pass, whatever becomes of the time of day."""
    return time.monotonic() if STEADY is None else time.clock_gettime(STEADY)


class RunClock:
    """Seconds since the start, pauses not counted; every timeout and wait of a run uses it."""

    def __init__(
        self,
        clock: Callable[[], float] = time.monotonic,
        time_of_day: Callable[[], datetime] = time_of_day,
        steady: Callable[[], float] = steady,
    ) -> None:
        self._clock = clock
        self._offset = clock()
        self._paused_at: float | None = None
        self._time_of_day = time_of_day
        self._steady = steady
        self.begin()

    def begin(self) -> None:
        """From now on `since` counts seconds that pass."""
        self._began, self._began_s = self._time_of_day(), self._steady()

    def since(self, moment: datetime) -> float:
        """Seconds since a moment; that the time of day was set after `begin` makes no difference."""
        return (self._began - moment).total_seconds() + self._steady() - self._began_s

    @classmethod
    def virtual(cls, clock: Callable[[], float]) -> "RunClock":
        """A clock for time that jumps; its time of day begins now and jumps with it."""
        began, at = time_of_day(), clock()
        return cls(clock, lambda: began + timedelta(seconds=clock() - at), clock)

    def now(self) -> float:
        """Seconds of running time."""
        return (self._clock() if self._paused_at is None else self._paused_at) - self._offset

    def time_of_day(self) -> datetime:
        """Now, to the millisecond; pauses make no difference to it."""
        found = self._time_of_day()
        return found.replace(microsecond=found.microsecond // 1000 * 1000)

    def pause(self) -> None:
        """Stop the clock."""
        if self._paused_at is None:
            self._paused_at = self._clock()

    def go_on(self) -> None:
        """Continue from where it stopped."""
        if self._paused_at is not None:
            self._offset += self._clock() - self._paused_at
            self._paused_at = None
