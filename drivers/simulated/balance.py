"""A simulated balance: it drifts, flickers, needs time to settle, and weighs what is dropped on it.

Configuration: `load_g` (the initial load on the pan), `pipette` (the device whose drops fall on the
pan, by its name in the lab).
"""

import math
from random import Random
from typing import Any, ClassVar

from ..driver import ActionFailed, GoalContext, Place
from .twins.settling import settled
from .twins.twin import Twin

RANGE_G = 220.0
ZERO_RANGE_G = 0.02 * RANGE_G
RESOLUTION_G = 0.0001
NOISE_G = 0.00005
DRIFT_G, DRIFT_S = 0.0004, 1800.0  # how far the reading wanders, and how slowly
LAG_S, TICK_S = 0.7, 0.25
STILL, STILL_G = 4, 0.0004  # so many readings within so little are a stable one
PATIENCE_S = 10.0


class SimBalance(Twin):
    """Implements balance@1; zero and tare outlive its server, as they would in the instrument.

    Its memory is the log of the truth: that it was tared, and by which goal, is one write.
    """

    contract: ClassVar[str] = "balance@1"
    options: ClassVar[tuple[str, ...]] = ("load_g", "pipette")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.zero_g = self.tare_g = 0.0
        self.newest = ""
        self.tared: dict[str, str] = {}
        """Run -> its newest zero or tare."""
        self.lagging_g = 0.0
        self.stable = True

    async def open(self) -> None:
        await super().open()
        for entry in self.truth.entries():
            if "zero_g" in entry:
                self._learn(entry)
        self.lagging_g = self._load()

    async def status(self) -> dict[str, Any]:
        mass = self.lagging_g + self._drift() - self.zero_g - self.tare_g
        return {"mass": _rounded(mass), "stable": self.stable, "tared": self.tare_g != 0}

    async def zero(self, goal: GoalContext) -> dict[str, Any]:
        with self.failing("zero", goal):
            gross = await self._still(goal)
            if abs(gross) > ZERO_RANGE_G:
                raise ActionFailed(
                    "NotEmpty", f"{gross:.4f} g on the pan; up to {ZERO_RANGE_G:g} g can be zeroed"
                )
            self._keep(goal, "zero", zero_g=gross, tare_g=0.0)
        return {}

    async def tare(self, goal: GoalContext) -> dict[str, Any]:
        with self.failing("tare", goal):
            gross = await self._still(goal)
            self._keep(goal, "tare", zero_g=self.zero_g, tare_g=gross - self.zero_g)
        return {"tare": _rounded(self.tare_g)}

    async def last_tare(self, goal: GoalContext) -> dict[str, Any]:
        return {"goal_id": self.newest, "tare": _rounded(self.tare_g)}  # empty is never

    async def weigh(self, goal: GoalContext, *, patience: float = PATIENCE_S) -> dict[str, Any]:
        with self.failing("weigh", goal):
            gross, self.stable = await self._settle(goal, patience)
            own = self.tared.get(_run(goal.id), self.newest)
            if own != self.newest:
                raise ActionFailed("TareLost", f"{self.newest} has zeroed or tared it since {own}")
            mass = _rounded(gross - self.zero_g - self.tare_g)
            self.truth.append("weigh", goal=goal.id, load_g=self._load(), shown_g=mass)
        return {"mass": mass, "stable": self.stable}

    async def _still(self, goal: GoalContext) -> float:
        gross, self.stable = await self._settle(goal, PATIENCE_S)
        if not self.stable:
            raise ActionFailed("Unstable", f"no stable reading within {PATIENCE_S:g} s")
        return gross

    async def _settle(self, goal: GoalContext, patience_s: float) -> tuple[float, bool]:
        """The newest reading, and whether the last few were the same."""
        random = Random(f"{self.seed}/{goal.id}")
        return await settled(
            self.clock, goal, lambda: self._reading(random), patience_s=patience_s, tick_s=TICK_S,
            still=STILL, within=STILL_G, words=lambda g: f"{g - self.zero_g - self.tare_g:.4f} g",
        )  # fmt: skip

    def _reading(self, random: Random) -> float:
        load = self._load()
        if load > RANGE_G:
            raise ActionFailed("Overload", f"{load:.1f} g on the pan; the range is {RANGE_G:g} g")
        self.lagging_g += (load - self.lagging_g) * (1 - math.exp(-TICK_S / LAG_S))
        return self.lagging_g + self._drift() + random.gauss(0, NOISE_G)

    def _drift(self) -> float:
        return DRIFT_G * math.sin(2 * math.pi * self.clock.elapsed_s / DRIFT_S)

    def _load(self) -> float:
        """The true load on the pan."""
        pipette = self.world.look(self.config.get("pipette", "pipette")) or {"dropped_mg": 0.0}
        return float(self.config.get("load_g", 0.0)) + pipette["dropped_mg"] / 1000

    def _keep(self, goal: GoalContext, what: str, *, zero_g: float, tare_g: float) -> None:
        self._learn(
            self.truth.append(what, goal=goal.id, load_g=self._load(), zero_g=zero_g, tare_g=tare_g)
        )

    def _learn(self, entry: dict[str, Any]) -> None:
        self.zero_g, self.tare_g = entry["zero_g"], entry["tare_g"]
        self.newest = self.tared[_run(entry["goal"])] = entry["goal"]


def _run(goal_id: str) -> str:
    return goal_id.partition("/")[0]


def _rounded(mass_g: float) -> float:
    """As the display shows it; never -0.0."""
    return round(round(mass_g / RESOLUTION_G) * RESOLUTION_G, 4) + 0.0
