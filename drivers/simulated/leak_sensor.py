"""A simulated leak sensor: a cable on the floor that conducts where it is wet.

Configuration: `leak_after_s` (when water reaches it, counted from its start), `dry_after_s` (when that has
dried), `breaks_after_s` (when its cable is cut).

A cut cable conducts as little as a dry floor. So such cables end in a resistor, and a sensor that does not
find it tells a fault, not "dry" (Raychem TTDM-1: "cable break"). It latches: a puddle that has dried is still
an alarm until somebody resets it (Carrier NSB-LDT4).
"""

from typing import Any, ClassVar

from ..driver import ActionFailed, GoalContext, Place
from .twins.twin import Twin

LOOK_S = 0.5


class SimLeakSensor(Twin):
    """Implements leak_sensor@1."""

    contract: ClassVar[str] = "leak_sensor@1"
    options: ClassVar[tuple[str, ...]] = (
        "leak_after_s", "dry_after_s", "breaks_after_s",
    )  # fmt: skip

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.alarm = False
        self.reset_by = ""
        self._began_s = 0.0

    async def open(self) -> None:
        await super().open()
        for entry in self.truth.entries():
            self.reset_by = entry["goal"]
        self._began_s = self.clock.now_s()

    async def status(self) -> dict[str, Any]:
        if self._is_broken():
            raise OSError("the leak sensor's cable is broken")
        return {"wet": self._look()}

    async def read(self, goal: GoalContext) -> dict[str, Any]:
        with self.failing("read", goal):
            await self.clock.sleep(LOOK_S)
            self._check_cable()
        return {"wet": self._look()}

    async def reset(self, goal: GoalContext) -> dict[str, Any]:
        with self.failing("reset", goal):
            await self.clock.sleep(LOOK_S)
            self._check_cable()
            if self._is_wet():
                raise ActionFailed("StillWet", "there is water on the floor")
            self.truth.append("reset", goal=goal.id)
            self.alarm, self.reset_by = False, goal.id
        return {}

    async def last_reset(self, goal: GoalContext) -> dict[str, Any]:
        return {"goal_id": self.reset_by}  # empty is never

    def _check_cable(self) -> None:
        if self._is_broken():
            raise ActionFailed("WireBroken", "the resistor at the cable's end is not found")

    def _look(self) -> bool:
        self.alarm = self.alarm or self._is_wet()
        return self.alarm

    def _is_wet(self) -> bool:
        return self._since("leak_after_s") and not self._since("dry_after_s")

    def _is_broken(self) -> bool:
        return self._since("breaks_after_s")

    def _since(self, name: str) -> bool:
        return self.clock.now_s() - self._began_s >= float(self.config.get(name, "inf"))
