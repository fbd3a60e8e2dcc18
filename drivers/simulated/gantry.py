"""A simulated gantry: it moves as the real one does, in whole steps and in real time.

Configuration: `homed` (ready without homing), `lost_steps` (the probability that a move loses
steps: the gantry's true position then differs from the reported one, until it is homed), `surface`
(the height at which its probe touches, mm), `keep_out`, `outputs` and `safe_z` as for a real gantry.
"""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any, ClassVar

from ..driver import ActionCanceled, ActionFailed, GoalContext, Place
from ..motion.bench import Bench
from ..motion.gantry import AnyGantry, jog_way
from ..motion.keep_out import read_boxes
from ..motion.legs import legs
from .twins.axis import SPEED_MM_PER_S, STEPS_PER_MM, Point, Steps, to_mm
from .twins.carriage import Carriage
from .twins.faults import chance
from .twins.travel import Ride, lapsed
from .twins.twin import Twin

AXES = "xyz"
# Homing lifts the tool before it goes to the corner, so that nothing is dragged over the bench.
HOME: Point = (0.0, 0.0, 100.0)
HERE: Point = (0.0, 0.0, 0.0)
"""Its own zero, which is the bench's."""
TRAVEL = {"x": 730.0, "y": 810.0, "z": 100.0}
"""As far as it goes from 0 where neither its contract nor its lab says how far."""
SURFACE_MM = 10.0
SEEK_S = 4.0  # touching each switch a second time, slowly


class SimGantry(AnyGantry, Twin):
    """Implements gantry@2 with three axes. Its true position is kept in the world, even across a kill."""

    without: ClassVar[str] = "gantry@1"
    options: ClassVar[tuple[str, ...]] = (
        "homed", "lost_steps", "surface", "keep_out", "outputs", "safe_z"
    )  # fmt: skip

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.alarm = ""
        self.carriage = Carriage(self.world, place.device, bool(self.config.get("homed", False)))
        self.ride = Ride(self.clock, self.carriage)
        self.percent = {"feed": 100, "rapid": 100}
        low, high = zip(*(self._range(axis) for axis in AXES), strict=True)
        self.bench = Bench((0, 1, 2), (1, 1, 1), HERE, low, high, read_boxes(self.config))

    async def open(self) -> None:
        await super().open()
        self.carriage.recall()

    async def status(self) -> dict[str, Any]:
        zero = to_mm(self.carriage.zero)
        work = zip(AXES, self.carriage.believed_mm, zero, strict=True)
        more = {
            **{f"machine_{axis}": value for axis, value in self._where().items()},
            **{f"{name}_override": percent for name, percent in self.percent.items()},
            "pins": "P" if self._touches() else "",
            "outputs": sorted(self.on),
            "alarm_code": None,
        }
        told = self.faults.contract.status.get("properties", {})
        return {
            "state": self._state(),
            "homed": self.carriage.homed,
            **self._where(),
            **{name: value for name, value in more.items() if name in told},
            **{f"work_{axis}": round(at - from_, 4) for axis, at, from_ in work},
            "feed": round(self.ride.feed_mm_per_min, 3),
            "alarm": self.alarm,
        }

    async def safe(self) -> None:
        self.ride.stop = True  # a move under way ends by itself, here and now
        self.on.clear()

    async def home(self, goal: GoalContext) -> dict[str, Any]:
        self.carriage.homed = False
        with self.failing("home", goal):
            self.carriage.find_switches()
            x, y, _ = self.carriage.believed_mm
            await self._go(goal, (x, y, HOME[2]), None, "homing")
            await self._go(goal, HOME, None, "homing")
            await self._touch_switches(goal)
            self.carriage.homed, self.alarm = True, ""
            self.carriage.publish()
        return {}

    async def _travel(
        self, goal: GoalContext, wanted: dict[str, float], feed: float | None, safe_z: float | None
    ) -> dict[str, Any]:
        self._check_ready()
        self._check_range(**wanted)
        if safe_z is not None:
            self._check_range(z=safe_z)
        at = dict(zip(AXES, self.carriage.believed_mm, strict=True))
        way = []
        for leg in legs(at, wanted, safe_z):
            at = at | leg
            way.append((at["x"], at["y"], at["z"]))
        return await self._moved("move_to", goal, way, feed)

    async def touch(
        self, goal: GoalContext, *, to: float, axis: str = "z", feed: float = 60.0
    ) -> dict[str, Any]:
        self._check_ready()
        self._check_range(**{axis: to})
        here = self.carriage.believed_mm
        self.bench.check_path(here, _with(here, axis, to), self._name())
        if self._touches():
            raise ActionFailed("Touching", "the probe touches already", "no")
        surface = float(self.config.get("surface", SURFACE_MM))
        touches = axis == "z" and to <= surface
        end = _with(here, axis, surface if touches else to)
        place = await self._moved("touch", goal, [end], feed)
        if not touches:
            words = f"the probe went to {axis} {to:g} mm and touched nothing"
            raise ActionFailed("NoContact", words, "yes")
        return place

    async def _switch(self, goal: GoalContext, output: str, on: bool, power: float) -> None:
        with self.failing("set_output", goal):
            (self.on.add if on else self.on.discard)(output)
            self.truth.append("output", goal=goal.id, output=output, on=on, power=power)

    async def override(
        self, goal: GoalContext, *, feed: int | None = None, rapid: int | None = None
    ) -> dict[str, Any]:
        given = {"feed": feed, "rapid": rapid}
        self.percent |= {name: value for name, value in given.items() if value is not None}
        return {}

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
        self._check_ready()
        here = dict(zip(AXES, self.carriage.believed_mm, strict=True))
        signs = jog_way(axis, direction, way)
        self.bench.check_axes(signs, self._name())
        if distance is not None:
            far, over = distance, None
            self._check_range(**{axis: here[axis] + sign * far for axis, sign in signs.items()})
        else:
            on_bench = {AXES.index(axis): sign for axis, sign in signs.items()}
            far = max(0.0, self.bench.reach(self.carriage.believed_mm, on_bench))
            if self.clock.leaps:  # no hand is on a clock that leaps: it lets go at once
                far = min(far, feed / 60 * lease / math.sqrt(len(signs)))
            over = lapsed(lambda: goal.wanted_at, lease)
        there = tuple(at + signs.get(axis, 0) * far for axis, at in here.items())
        self.by_hand = {"goal_id": goal.id}
        place = await self._moved("jog", goal, [(there[0], there[1], there[2])], feed, over)
        self.by_hand |= place
        return place

    async def hold(self, goal: GoalContext) -> dict[str, Any]:
        if self.ride.state == "moving":
            self.ride.hold = True
        elif self.ride.state == "homing":
            self.ride.stop = True  # as a real one: it cannot be gone on with
        return {}

    async def resume(self, goal: GoalContext) -> dict[str, Any]:
        self.ride.hold = False
        return {}

    async def set_zero(self, goal: GoalContext, *, axes: list[str] | None = None) -> dict[str, Any]:
        self.bench.check_axes(axes or (), self._name())
        self._check_ready()
        now = zip(AXES, self.carriage.steps, self.carriage.zero, strict=True)
        x, y, z = (at if axis in (axes or AXES) else old for axis, at, old in now)
        self.carriage.zero = (x, y, z)
        self.carriage.publish()
        place = _named(self.carriage.zero)
        self.truth.append("zero", goal=goal.id, **place)
        self.by_hand = {"goal_id": goal.id, **place}
        return place

    async def go_to_zero(
        self, goal: GoalContext, *, axes: list[str] | None = None, feed: float | None = None
    ) -> dict[str, Any]:
        self.bench.check_axes(axes or (), self._name())
        self._check_ready()
        zero, here = to_mm(self.carriage.zero), self.carriage.believed_mm
        there = zip(AXES, zero, here, strict=True)
        x, y, z = (to if axis in (axes or AXES) else at for axis, to, at in there)
        return await self._moved("go_to_zero", goal, [(x, y, z)], feed)

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        await self.safe()
        while self.ride.state != "idle":
            await self.clock.sleep(self.clock.tick_s)
        return {}

    async def unlock(self, goal: GoalContext) -> dict[str, Any]:
        if self.alarm:
            self.carriage.homed = False
        self.alarm = ""
        self.carriage.publish()
        return {}

    async def _moved(
        self,
        action: str,
        goal: GoalContext,
        way: list[Point],
        feed: float | None,
        over: Callable[[], bool] | None = None,
    ) -> dict[str, Any]:
        """A motion, line by line, that may have an injected fault, and that may lose steps."""
        for start, end in pairwise([self.carriage.believed_mm, *way]):
            self.bench.check_path(start, end, self._name())
        fastest = 60 * SPEED_MM_PER_S * self.percent["rapid"] / 100
        pace = fastest if feed is None else min(fastest, feed * self.percent["feed"] / 100)
        try:
            with self.failing(action, goal):
                for there in way:
                    await self._go(goal, there, pace, "moving", over)
        except ActionFailed as failure:
            self._after(failure)
            raise
        self._lose_steps(goal)
        return self._where()

    async def _go(
        self,
        goal: GoalContext,
        end: Point,
        feed: float | None,
        state: str,
        over: Callable[[], bool] | None = None,
    ) -> None:
        """Move, report progress, and stop on a cancel, a stop, or when it is `over`."""
        start = self.carriage.true
        ended = _either(goal.cancelled.is_set, over)
        arrived = False
        try:
            arrived = await self.ride.go(
                end, feed, state, ended, lambda part: goal.feedback(part, self.carriage.words())
            )
        finally:
            self._stand(goal, start)
        if not arrived and (goal.cancelled.is_set() or self.ride.stop):
            self._stopped_early(goal)

    async def _touch_switches(self, goal: GoalContext) -> None:
        left = SEEK_S
        while left > 0:
            pace = min(self.clock.tick_s, left)
            await self.clock.sleep(pace)
            left -= pace
            if goal.cancelled.is_set() or self.ride.stop:
                self._stopped_early(goal)

    def _state(self) -> str:
        return "alarm" if self.alarm and self.ride.state == "idle" else self.ride.state

    def _stand(self, goal: GoalContext, start: Steps) -> None:
        """Come to rest, for the world to see."""
        self.carriage.publish()
        self.truth.append(
            "move",
            goal=goal.id,
            start=_rounded(start),
            end=_rounded(self.carriage.true),
            elapsed_s=round(self.clock.elapsed_s, 3),
        )

    def _stopped_early(self, goal: GoalContext) -> None:
        place = self.carriage.words()
        if goal.cancelled.is_set():
            raise ActionCanceled(f"stopped at {place}")
        raise ActionFailed("Alarm", f"a stop ended the move at {place}", "yes")

    def _check_ready(self) -> None:
        if self.alarm:
            raise ActionFailed("Alarm", "the gantry is in alarm: unlock or home it first", "no")
        if not self.carriage.homed:
            raise ActionFailed("NotHomed", "the gantry's position is unknown: home it first")

    def _range(self, axis: str) -> tuple[float, float]:
        """The range of the axis on this bench."""
        schema = self.faults.contract.actions["move_to"].param_schemas()[axis]
        low, high = self.place.limits.get(axis, (None, None))
        return (
            schema.get("minimum", 0.0) if low is None else low,
            schema.get("maximum", TRAVEL[axis]) if high is None else high,
        )

    def _touches(self) -> bool:
        surface = float(self.config.get("surface", SURFACE_MM))
        return self.carriage.believed_mm[2] <= surface + 0.003

    def _check_range(self, **wanted: float) -> None:
        self.bench.check_axes(wanted, self._name())
        self.bench.check_range(wanted, self._name())

    def _after(self, failure: ActionFailed) -> None:
        """An injected alarm locks the gantry; a stop does not."""
        if failure.name == "Alarm" and failure.happened is None:
            self.alarm = f"{failure.message}. Unlock it, or home it"
        if failure.name == "NotHomed":
            self.carriage.homed = False
        self.carriage.publish()

    def _lose_steps(self, goal: GoalContext) -> None:
        if chance(self.seed, "lost_steps", goal.id) >= float(self.config.get("lost_steps", 0)):
            return
        lost = 2 + round(38 * chance(self.seed, "how many", goal.id))  # 0.01 to 0.2 mm
        x, y, z = self.carriage.slip
        self.carriage.slip = (x - lost, y, z)
        self.carriage.publish()
        self.truth.append("lost_steps", goal=goal.id, x_mm=round(-lost / STEPS_PER_MM, 4))

    def _where(self) -> dict[str, float]:
        return _named(self.carriage.steps)


def _rounded(steps: Steps) -> list[float]:
    return [round(value, 4) for value in to_mm(steps)]


def _named(steps: Steps) -> dict[str, float]:
    return dict(zip(AXES, _rounded(steps), strict=True))


def _with(place: Point, axis: str, value: float) -> Point:
    x, y, z = (float(value) if name == axis else at for name, at in zip(AXES, place, strict=True))
    return x, y, z


def _either(first: Callable[[], bool], second: Callable[[], bool] | None) -> Callable[[], bool]:
    return first if second is None else lambda: first() or second()
