"""The clock of a twin: real seconds, scaled seconds, or seconds that are only counted."""

import asyncio

from ....system.tasks import in_time

TICKS_S = {"real": 0.05, "fast": float("inf"), "rehearsal": 1.0}
SHORTEST_S = 1e-6
"""No sleep is shorter: within a clock's own rounding no time would pass on one that leaps, and what is
left of an action would be slept for again and again."""


class Clock:
    """`elapsed_s` counts every second slept, on either clock.

    The fast clock sleeps nothing but yields each time, so that others get their turn as they
    would on the real one. A number is how many times faster than real the clock runs. `rehearsal`
    sleeps every second, on a loop whose time leaps.

    Where it `leaps`, no person can do anything meanwhile. `tick_s` is how often something that
    goes on looks about itself. `slower` is how many times as long each sleep takes: a device that is
    not well; its own seconds are as many as ever.
    """

    def __init__(self, kind: str | float = "real") -> None:
        self.fast = kind == "fast"
        self.leaps = kind in ("fast", "rehearsal")
        self.speed = 1.0 if kind in TICKS_S else _speed(kind)
        self.tick_s = TICKS_S[kind] if isinstance(kind, str) else TICKS_S["real"] * self.speed
        self.elapsed_s = 0.0
        self.slower = 1.0

    def now_s(self) -> float:
        """Seconds on a clock that also goes on while nobody sleeps, where any does."""
        return self.elapsed_s if self.fast else asyncio.get_running_loop().time() * self.speed

    async def sleep(self, seconds: float) -> None:
        """Let this many seconds pass."""
        seconds = max(SHORTEST_S, seconds)
        await asyncio.sleep(0 if self.fast else seconds * self.slower / self.speed)
        self.elapsed_s += seconds

    async def sleep_unless(self, stop: asyncio.Event, seconds: float) -> bool:
        """Let this many seconds pass, or fewer when `stop` is set meanwhile; whether it was."""
        seconds = max(SHORTEST_S, seconds)
        if self.fast:
            await asyncio.sleep(0)
        else:
            await in_time(stop.wait(), seconds * self.slower / self.speed)
        self.elapsed_s += seconds
        return stop.is_set()


def _speed(kind: object) -> float:
    if isinstance(kind, int | float) and 0 < kind < float("inf"):
        return float(kind)
    raise ValueError(
        f"clock is {kind!r}; it must be real, fast, or how many times faster than real it runs"
    )
