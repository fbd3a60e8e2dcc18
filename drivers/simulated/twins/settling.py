"""A reading that needs time: asked for again and again until the last few are the same."""

import math
from collections.abc import Callable

from ...driver import ActionCanceled, GoalContext
from .clock import Clock


async def settled(
    clock: Clock, goal: GoalContext, read: Callable[[], float], *,
    patience_s: float, tick_s: float, still: int, within: float, words: Callable[[float], str],
) -> tuple[float, bool]:  # fmt: skip
    """The mean of the last `still` readings, and True; the newest and False when patience ends."""
    readings: list[float] = []
    for _ in range(max(1, math.ceil(patience_s / tick_s))):
        await clock.sleep(tick_s)
        if goal.cancelled.is_set():
            raise ActionCanceled("the reading was stopped")
        readings.append(read())
        goal.feedback(None, words(readings[-1]))
        newest = readings[-still:]
        if len(newest) == still and max(newest) - min(newest) <= within:
            return sum(newest) / still, True
    return readings[-1], False
