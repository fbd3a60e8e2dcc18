"""A simulated dispenser: a pump for each liquid, nearly the requested volume, into named vessels.

Configuration: `liquids` (their names), `bottle_ml` (of each at first), `vessels` (names it reaches;
without it, any), `ul_per_s` (how fast its pumps are).
"""

import asyncio
from collections import defaultdict
from random import Random
from typing import Any, ClassVar

from ..driver import ActionFailed, GoalContext, Place
from .twins.twin import Twin

MG_PER_UL = 1.0  # water
BIAS, SPREAD, LEAST_UL = 0.003, 0.004, 0.1
START_S, UL_PER_S = 1.0, 250.0
UNDER_THE_OUTLET = "vessel"


class SimDispenser(Twin):
    """Implements dispenser@1; its memory is the log of the truth.

    A pump has a controller of its own: once started it delivers its volume, whatever becomes of
    the server. So the line is written when it starts, and a halt writes how much did not come.
    """

    contract: ClassVar[str] = "dispenser@1"
    options: ClassVar[tuple[str, ...]] = ("liquids", "bottle_ml", "vessels", "ul_per_s")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.vessels = [str(name) for name in self.config.get("vessels", [])]
        bottle_ul = 1000 * float(self.config.get("bottle_ml", 250))
        self.left_ul = {str(name): bottle_ul for name in self.config.get("liquids", ["water"])}
        self.held_ul: dict[str, dict[str, float]] = defaultdict(lambda: defaultdict(float))
        self.newest: dict[str, Any] = {"goal_id": "", "liquid": None, "volume": 0.0, "left": 0.0}
        self.refill: dict[str, Any] = {"goal_id": "", "liquid": None}
        self.flowing: str | None = None
        self._halted = asyncio.Event()

    async def open(self) -> None:
        await super().open()
        for line in self.truth.entries():
            self._happened(line)
        self._publish()

    async def status(self) -> dict[str, Any]:
        left = {name: _ml(volume) for name, volume in self.left_ul.items()}
        return {"dispensing": self.flowing, "left": left}

    async def safe(self) -> None:
        self._halted.set()

    async def dispense(
        self, goal: GoalContext, *, liquid: str, volume: float, into: str | None = None
    ) -> dict[str, Any]:
        self._check(liquid)
        if into is not None and self.vessels and into not in self.vessels:
            raise ActionFailed(
                "NoSuchVessel", f"there is no {into}; it reaches {', '.join(self.vessels)}"
            )
        if volume > self.left_ul[liquid]:
            raise ActionFailed(
                "Empty", f"{_ml(self.left_ul[liquid]):g} mL of {liquid} are left: fill it up"
            )
        self._halted.clear()
        with self.failing("dispense", goal):
            truly_ul = self._true_volume(volume, goal)
            vessel = UNDER_THE_OUTLET if into is None else into
            self._log("dispense", goal, liquid, vessel, volume, truly_ul)
            await self._flow(goal, liquid, vessel, volume, truly_ul)
        return {"volume": volume, "left": _ml(self.left_ul[liquid])}

    async def last_dispense(self, goal: GoalContext) -> dict[str, Any]:
        return dict(self.newest)  # its memory outlives a kill: an empty goal_id means never

    async def refilled(self, goal: GoalContext, *, liquid: str, volume: float) -> dict[str, Any]:
        self._check(liquid)
        with self.failing("refilled", goal):
            line = {"what": "refilled", "liquid": liquid, "volume_ul": 1000 * volume}
            self._happened(self.truth.append(**line, goal=goal.id))
        return {}

    async def last_refill(self, goal: GoalContext) -> dict[str, Any]:
        return dict(self.refill)

    async def halt(self, goal: GoalContext) -> dict[str, Any]:
        self._halted.set()
        return {}

    async def _flow(
        self, goal: GoalContext, liquid: str, vessel: str, volume: float, truly_ul: float
    ) -> None:
        """Until all of it is in the vessel, or the pumps are halted."""
        self.flowing = liquid
        lasts_s = START_S + volume / float(self.config.get("ul_per_s", UL_PER_S))
        begun = asyncio.get_running_loop().time()
        try:
            halted = await self.clock.sleep_unless(self._halted, lasts_s)
        finally:
            self.flowing = None
            self._publish()
        if not halted or self.clock.fast:
            return
        flowed_s = (asyncio.get_running_loop().time() - begun) * self.clock.speed - START_S
        part = min(1.0, max(0.0, flowed_s / (lasts_s - START_S)))
        if part < 1:
            self._log("halt", goal, liquid, vessel, -(1 - part) * volume, -(1 - part) * truly_ul)
            self._publish()
            raise ActionFailed("Halted", f"{part * volume:.1f} of {volume:g} uL were delivered")

    def _check(self, liquid: str) -> None:
        if liquid not in self.left_ul:
            raise ActionFailed(
                "NoSuchLiquid", f"there is no {liquid}; it has {', '.join(self.left_ul)}"
            )

    def _true_volume(self, volume: float, goal: GoalContext) -> float:
        random = Random(f"{self.seed}/{goal.id}")
        error = random.gauss(BIAS, SPREAD) * volume + random.gauss(0, LEAST_UL)
        return max(0.0, volume + error)

    def _log(
        self, what: str, goal: GoalContext, liquid: str, into: str, volume: float, truly_ul: float
    ) -> None:
        line = {"liquid": liquid, "into": into, "volume_ul": volume, "truly_ul": truly_ul}
        self._happened(self.truth.append(what, goal=goal.id, **line))

    def _happened(self, line: dict[str, Any]) -> None:
        """What one line of the log means for bottles, vessels and memory."""
        liquid, volume_ul = line["liquid"], line["volume_ul"]
        if line["what"] == "refilled":
            self.left_ul[liquid] = volume_ul
            self.refill = {"goal_id": line["goal"], "liquid": liquid}
            return
        if line["what"] == "dispense":
            self.newest = {"goal_id": line["goal"], "liquid": liquid, "volume": 0.0}
        self.left_ul[liquid] = max(0.0, self.left_ul.get(liquid, 0.0) - volume_ul)
        self.held_ul[line["into"]][liquid] += line["truly_ul"]
        self.newest["volume"] = round(self.newest["volume"] + volume_ul, 3)
        self.newest["left"] = _ml(self.left_ul[liquid])

    def _publish(self) -> None:
        """Vessels for what looks into them, and the weight for a balance below."""
        total_ul = sum(sum(held.values()) for held in self.held_ul.values())
        state = {"vessels": self.held_ul, "dropped_mg": total_ul * MG_PER_UL}
        self.world.publish(self.place.device, state)


def _ml(volume_ul: float) -> float:
    return round(volume_ul / 1000, 6)
