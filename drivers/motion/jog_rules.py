"""Jog: the checks before an axis moves by hand, whatever moves it."""

import time
from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from ..driver import ActionFailed, GoalContext
from .bench import Point
from .gantry import AXES
from .real_gantry import RealGantry

CREEP_MM, CREEP_FEED = 10.0, 300.0
"""How far (mm) and fast (mm/min) a jog may go before homing, to get off a switch."""


class JogRules(RealGantry):
    """A jog by a distance ends there; one in a direction lasts while its goal keeps being sent."""

    @abstractmethod
    async def _jog_by(self, goal: GoalContext, axis: int, distance: float, feed: float) -> None:
        """Move a machine axis by a distance and prove that it stopped."""

    @abstractmethod
    async def _jog_while(
        self, goal: GoalContext, axis: int, way: float, feed: float, held: Callable[[], bool]
    ) -> None:
        """Move a machine axis along `way` at most, while it is held; prove that it stopped."""

    async def jog(
        self,
        goal: GoalContext,
        *,
        axis: str,
        distance: float | None = None,
        direction: str | None = None,
        feed: float = 600.0,
        lease: float = 0.3,
    ) -> dict[str, Any]:
        self.bench.check_axes(axis, self._name())
        await self._ready()
        self._check_creep(distance)
        with self._telling(f"jog {axis}", before=True):
            here = self.bench.to_bench(await self._machine())
        i = AXES.index(axis)
        sign = 1 if (distance or 0) > 0 or direction == "+" else -1
        way = self._edge(here, i, sign) if distance is None else self._allowed(here, i, distance)
        feed = feed if self.homed else min(feed, CREEP_FEED)
        machine_axis, machine_way = self.bench.index[i], self.bench.sign[i] * way
        with self._telling(f"jog {axis} by {way:g} mm"):
            self.by_hand = {"goal_id": goal.id}
            if way * sign > 0 and distance is not None:
                await self._jog_by(goal, machine_axis, machine_way, feed)
            elif way * sign > 0:
                await self._jog_while(goal, machine_axis, machine_way, feed, held(goal, lease))
            self.by_hand |= self._place(await self._machine())
        return {axis: self.by_hand[axis] for axis in self.bench.axes}

    def _edge(self, here: Point, axis: int, sign: int) -> float:
        """How far it may go in this direction."""
        return self.bench.reach(here, axis, sign) - here[axis] if self.homed else sign * CREEP_MM

    def _allowed(self, here: Point, axis: int, distance: float) -> float:
        """The distance, if it is allowed."""
        if not -1e6 < distance < 1e6:
            raise ActionFailed("SoftLimit", f"{self._name()} was not moved: {distance:g} mm", "no")
        if self.homed:
            end = list(here)
            end[axis] += distance
            self.bench.check_range({AXES[axis]: end[axis]}, self._name())
            self.bench.check_path(here, tuple(end), self._name())
        return float(distance)

    def _check_creep(self, distance: float | None) -> None:
        if self.homed:
            return
        if self._locked():
            words = f"{self._name()} was not moved: it is locked until it is homed or unlocked"
            raise ActionFailed("NotHomed", words, "no")
        if distance is not None and not abs(distance) <= CREEP_MM:
            raise ActionFailed(
                "NotHomed",
                f"{self._name()} is not homed: until then a jog goes {CREEP_MM:g} mm at most",
                "no",
            )


def held(goal: GoalContext, lease_s: float) -> Callable[[], bool]:
    """A jog is held while its goal has been sent again within the lease."""
    begun = time.monotonic()
    return lambda: time.monotonic() - max(goal.wanted_at, begun) < lease_s
