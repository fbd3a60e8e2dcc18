"""A gantry without hardware: it moves as the real one does, in whole steps and in real time.

Configuration: `homed` (stands ready without homing), `lost_steps` (the chance that a move loses
steps: the gantry then stands elsewhere than it says, until it is homed).
"""

from typing import Any, ClassVar

from .driver import ActionCanceled, ActionFailed, GoalContext, Place
from .twins.axis import STEPS_PER_MM, Move, Point, Steps, plan, to_mm, to_steps
from .twins.carriage import Carriage
from .twins.faults import chance
from .twins.twin import Twin

# Homing lifts the tool before it goes to the corner, so that nothing is dragged over the bench.
HOME: Point = (0.0, 0.0, 100.0)
SEEK_S = 4.0  # touching each switch a second time, slowly


class SimGantry(Twin):
    """Keeps gantry@1. Where it truly stands is the world's to know, also after a kill."""

    contract: ClassVar[str] = "gantry@1"
    options: ClassVar[tuple[str, ...]] = ("homed", "lost_steps")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.state = "idle"
        self.carriage = Carriage(self.world, place.device, bool(self.config.get("homed", False)))
        self._stop = False

    async def open(self) -> None:
        await super().open()
        self.carriage.recall()

    async def status(self) -> dict[str, Any]:
        return {"state": self.state, "homed": self.carriage.homed, **self._where()}

    async def safe(self) -> None:
        self._stop = True  # a move under way ends by itself, here and now

    async def home(self, goal: GoalContext) -> dict[str, Any]:
        self.carriage.homed = False
        with self.failing("home", goal):
            self.carriage.find_switches()
            x, y, _ = self.carriage.believed_mm
            await self._go(goal, (x, y, HOME[2]), None, "homing")
            await self._go(goal, HOME, None, "homing")
            await self.clock.sleep(SEEK_S)
            self.carriage.homed = True
            self.carriage.publish()
        return {}

    async def move_to(
        self,
        goal: GoalContext,
        *,
        x: float | None = None,
        y: float | None = None,
        z: float | None = None,
        feed: float | None = None,
    ) -> dict[str, Any]:
        if self.state == "alarm":
            raise ActionFailed("Alarm", "the gantry is in alarm: unlock or home it first", "no")
        if not self.carriage.homed:
            raise ActionFailed("NotHomed", "the gantry does not know where it is: home it first")
        self._check_limits(x=x, y=y, z=z)
        here = self.carriage.believed_mm
        there = (
            here[0] if x is None else float(x),
            here[1] if y is None else float(y),
            here[2] if z is None else float(z),
        )
        try:
            with self.failing("move_to", goal):
                await self._go(goal, there, feed, "moving")
        except ActionFailed as failure:
            self._after(failure)
            raise
        self._lose_steps(goal)
        return self._where()

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        return {}  # one goal at a time: nothing moves when this one begins

    async def unlock(self, goal: GoalContext) -> dict[str, Any]:
        if self.state == "alarm":
            self.carriage.homed = False
        self.state = "idle"
        self.carriage.publish()
        return {}

    async def _go(self, goal: GoalContext, end: Point, feed: float | None, state: str) -> None:
        """Move, tell how far it is, and stop on a cancel or a stop."""
        start, self._stop = self.carriage.true, False
        move = plan(self.carriage.believed_mm, to_mm(to_steps(end)), feed)
        self.state = state
        try:
            travelled = await self._travel(goal, move)
            self.carriage.steps = to_steps(move.point(travelled))
        finally:
            self.state = "idle"
            self._stand(goal, start)
        if travelled < move.length:
            self._stopped_early(goal)

    async def _travel(self, goal: GoalContext, move: Move) -> float:
        """Millimetres along the line where it came to stand."""
        t = 0.0
        while t < move.duration_s:
            if goal.cancelled.is_set() or self._stop:
                await self.clock.sleep(move.speed_at(t) / move.acceleration)
                return move.braked_at(t)
            pace = min(self.clock.tick_s, move.duration_s - t)
            await self.clock.sleep(pace)
            t += pace
            self.carriage.steps = to_steps(move.point(move.travelled(t)))
            if not self.clock.fast:
                self.carriage.publish()
            goal.feedback(min(1.0, move.travelled(t) / move.length), self.carriage.words())
        return move.length

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

    def _check_limits(self, **wanted: float | None) -> None:
        schemas = self.faults.contract.actions["move_to"].param_schemas()
        for axis, value in wanted.items():
            low, high = self.place.limits.get(axis, (None, None))
            low = schemas[axis]["minimum"] if low is None else low
            high = schemas[axis]["maximum"] if high is None else high
            if value is not None and not low <= value <= high:
                message = f"{axis} {value:g} mm is outside {low:g} to {high:g} mm"
                raise ActionFailed("SoftLimit", message)

    def _after(self, failure: ActionFailed) -> None:
        """An alarm that was ordered locks the gantry; a stop does not."""
        if failure.name == "Alarm" and failure.happened is None:
            self.state = "alarm"
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
        return dict(zip("xyz", _rounded(self.carriage.steps), strict=True))


def _rounded(steps: Steps) -> list[float]:
    return [round(value, 4) for value in to_mm(steps)]
