"""A simulated piston burette: whole steps, a little backlash after each filling, a small cylinder.

Configuration: `cylinder_ml`, `bottle_ml` (what there is to fill it from).

A burette of 10,000 steps doses no less than a ten-thousandth of its cylinder, and says what it did; the
error of its cylinder is one of proportion. After a filling the piston turns round, and the slack of its
spindle is a part of the first dose that does not come.
"""

import asyncio
from random import Random
from typing import Any, ClassVar

from ..driver import ActionCanceled, ActionFailed, GoalContext, Place
from .twins.twin import Twin

STEPS = 10_000
BIAS, SPREAD_ML, BACKLASH_ML = 0.001, 0.0005, 0.004
ML_PER_S, FILL_ML_PER_S, START_S = 0.5, 1.0, 0.5


class SimPump(Twin):
    """Implements pump@1; its memory is the log of the truth, written as the piston starts."""

    contract: ClassVar[str] = "pump@1"
    options: ClassVar[tuple[str, ...]] = ("cylinder_ml", "bottle_ml")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.cylinder_ml = float(self.config.get("cylinder_ml", 10))
        self.now: dict[str, Any] = {
            "goal": "", "volume": 0.0, "level": 0.0, "dosed": 0.0, "truly_ml": 0.0, "slack": 0.0,
            "bottle_ml": float(self.config.get("bottle_ml", 1000)),
        }  # fmt: skip
        self._halted = asyncio.Event()

    async def open(self) -> None:
        await super().open()
        if newest := self.truth.entry(len(self.truth)):
            self.now = newest["after"]
        self._publish()

    async def status(self) -> dict[str, Any]:
        return {name: round(self.now[name], 4) for name in ("level", "dosed")}

    async def safe(self) -> None:
        self._halted.set()

    async def fill(self, goal: GoalContext) -> dict[str, Any]:
        wanted = self.cylinder_ml - self.now["level"]
        with self.failing("fill", goal):
            if await self.clock.sleep_unless(goal.cancelled, START_S + wanted / FILL_ML_PER_S):
                raise ActionCanceled("it was stopped before it began to draw")
            drawn = min(wanted, self.now["bottle_ml"])
            level, bottle = self.now["level"] + drawn, self.now["bottle_ml"] - drawn
            slack = BACKLASH_ML if drawn else self.now["slack"]
            self._become("fill", goal, level=level, bottle_ml=bottle, slack=slack)
        if drawn < wanted - 1e-9:
            raise ActionFailed(
                "NoLiquid", f"the bottle is empty, the cylinder holds {level:.2f} mL"
            )
        return {"level": round(level, 4)}

    async def dose(self, goal: GoalContext, *, volume: float) -> dict[str, Any]:
        step = self.cylinder_ml / STEPS
        volume = round(max(1, round(volume / step)) * step, 6)
        if volume > self.now["level"] + 1e-9:
            raise ActionFailed("TooLittle", f"{self.now['level']:.3f} mL are left: fill it first")
        self._halted.clear()
        error = Random(f"{self.seed}/{goal.id}").gauss(0, SPREAD_ML)
        truly_ml = max(0.0, volume * (1 + BIAS) + error - self.now["slack"])
        with self.failing("dose", goal):
            # A controller of its own finishes the dose, whatever becomes of the server.
            self._dosed("dose", goal, volume, truly_ml)
            begun, lasts_s = self.clock.now_s(), START_S + volume / ML_PER_S
            if await self.clock.sleep_unless(self._halted, lasts_s):
                left = 1 - min(1.0, (self.clock.now_s() - begun) / lasts_s)
                self._dosed("halt", goal, -left * volume, -left * truly_ml)
                raise ActionFailed("Halted", f"{(1 - left) * volume:.3f} of {volume:g} mL are out")
        return self._newest()

    async def last_dose(self, goal: GoalContext) -> dict[str, Any]:
        return {
            "goal_id": self.now["goal"],
            **self._newest(),
        }  # its memory is whole: empty is never

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        self._halted.set()
        return {}

    def _newest(self) -> dict[str, Any]:
        return {name: round(self.now[name], 6) for name in ("volume", "level")}

    def _dosed(self, what: str, goal: GoalContext, volume: float, truly_ml: float) -> None:
        """The instant of the dose, or of what a halt takes back of it."""
        again = self.now["volume"] if what == "halt" else 0.0
        self._become(
            what, goal, goal=goal.id, volume=again + volume, slack=0.0,
            level=max(0.0, self.now["level"] - volume), dosed=self.now["dosed"] + volume,
            truly_ml=self.now["truly_ml"] + truly_ml,
        )  # fmt: skip

    def _become(self, what: str, by: GoalContext, **after: Any) -> None:
        self.now = {**self.now, **after}
        self.truth.append(what, goal=by.id, after=self.now)
        self._publish()

    def _publish(self) -> None:
        self.world.publish(self.place.device, {"dosed_ml": self.now["truly_ml"]})
