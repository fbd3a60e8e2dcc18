"""Jog: the checks before axes move by hand, whatever moves them."""

import time
from abc import abstractmethod
from collections.abc import Callable
from typing import Any

from ..driver import ActionFailed, GoalContext
from .bench import Point
from .gantry import AXES, jog_way
from .real_gantry import RealGantry

CREEP_MM, CREEP_FEED = 10.0, 300.0
"""How far (mm) and fast (mm/min) a jog may go before homing, to get off a switch."""


class JogRules(RealGantry):
    """A jog by a distance ends there; one in a direction lasts while its goal keeps being sent."""

    @abstractmethod
    async def _jog_by(self, goal: GoalContext, by: dict[int, float], feed: float) -> None:
        """Move machine axes by distances, in a straight line, and prove that they stopped."""

    @abstractmethod
    async def _jog_while(
        self, goal: GoalContext, far: dict[int, float], feed: float, held: Callable[[], bool]
    ) -> None:
        """Move machine axes so far at most (each as far), while it is held; prove that they stopped."""

    async def jog(
        self,
        goal: GoalContext,
        *,
        axis: str | None = None,
        distance: float | None = None,
        direction: str | None = None,
        way: str | None = None,
        feed: float = 600.0,
        lease: float = 0.3,
    ) -> dict[str, Any]:
        signs = jog_way(axis, direction, way)
        self.bench.check_axes(signs, self._name())
        await self._ready()
        self._check_creep(distance)
        with self._telling(f"jog {''.join(signs)}", before=True):
            here = self.bench.to_bench(await self._machine())
        on_bench = {AXES.index(axis): sign for axis, sign in signs.items()}
        far = self._far(here, on_bench) if distance is None else distance
        if distance is not None:
            self._check_jog(here, {i: sign * distance for i, sign in on_bench.items()})
        feed = feed if self.homed else min(feed, CREEP_FEED)
        machine = {self.bench.index[i]: self.bench.sign[i] * s * far for i, s in on_bench.items()}
        with self._telling(f"jog {''.join(signs)} by {far:g} mm"):
            self.by_hand = {"goal_id": goal.id}
            if distance:
                await self._jog_by(goal, machine, feed)
            elif far > 0:
                await self._jog_while(goal, machine, feed, held(goal, lease))
            self.by_hand |= self._place(await self._machine())
        return {axis: self.by_hand[axis] for axis in self.bench.axes}

    def _far(self, here: Point, way: dict[int, int]) -> float:
        """How far it may go."""
        return self.bench.reach(here, way) if self.homed else CREEP_MM

    def _check_jog(self, here: Point, by: dict[int, float]) -> None:
        """Raise SoftLimit for a jog that is not allowed."""
        if not all(-1e6 < distance < 1e6 for distance in by.values()):
            words = f"{self._name()} was not moved: {next(iter(by.values())):g} mm"
            raise ActionFailed("SoftLimit", words, "no")
        if self.homed:
            end = tuple(at + by.get(axis, 0.0) for axis, at in enumerate(here))
            self.bench.check_range({AXES[axis]: end[axis] for axis in by}, self._name())
            self.bench.check_path(here, end, self._name())

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
