"""The time of a twin: real seconds, or seconds that are only counted."""

import asyncio
from contextlib import suppress

TICK_S = 0.05
KINDS = ("real", "fast")


class Clock:
    """`elapsed_s` counts every second slept, on either clock.

    The fast clock sleeps nothing but yields each time, so that others get their turn as they
    would on the real one.
    """

    def __init__(self, kind: str = "real") -> None:
        if kind not in KINDS:
            raise ValueError(f"clock is {kind!r}; it is one of: {', '.join(KINDS)}")
        self.fast = kind == "fast"
        self.elapsed_s = 0.0

    async def sleep(self, seconds: float) -> None:
        """Let this many seconds pass."""
        await asyncio.sleep(0 if self.fast else seconds)
        self.elapsed_s += seconds

    async def sleep_unless(self, stop: asyncio.Event, seconds: float) -> bool:
        """Let this many seconds pass, or fewer when `stop` is set meanwhile; whether it was."""
        if self.fast:
            await asyncio.sleep(0)
        else:
            with suppress(TimeoutError):
                async with asyncio.timeout(seconds):
                    await stop.wait()
        self.elapsed_s += seconds
        return stop.is_set()
