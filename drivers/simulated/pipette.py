"""A simulated pipette: nearly the requested volume, and every drop falls on the balance.

Configuration: `tips` (in the rack), `reservoir_ul` (of water to draw from).
"""

import asyncio
from dataclasses import asdict, dataclass, replace
from random import Random
from typing import Any, ClassVar

from ..driver import ActionFailed, GoalContext, Place
from .twins.twin import Twin

FULL_UL = 1000.0
MG_PER_UL = 1.0  # water
BIAS, SPREAD, LEAST_UL = 0.002, 0.005, 0.08  # ISO 8655 would let it pass
STROKE_S, TIP_S, EJECT_S = 3.0, 4.0, 2.0


@dataclass(frozen=True, slots=True)
class Filling:
    """The pipette after its newest stroke, and which goal that served.

    `volume_ul` is what the instrument believes to hold, `held_ul` what it does hold.
    """

    tip: bool = False
    volume_ul: float = 0.0
    held_ul: float = 0.0
    tips_left: int = 96
    reservoir_ul: float = 0.0
    dropped_mg: float = 0.0
    action: str | None = None
    goal: str | None = None


class SimPipette(Twin):
    """Implements pipette@1; its memory is the latest line of the log of the truth."""

    contract: ClassVar[str] = "pipette@1"
    options: ClassVar[tuple[str, ...]] = ("tips", "reservoir_ul")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.now = Filling(
            tips_left=int(self.config.get("tips", 96)),
            reservoir_ul=float(self.config.get("reservoir_ul", 50_000)),
        )
        self._held = asyncio.Event()

    async def open(self) -> None:
        await super().open()
        if newest := self.truth.entry(len(self.truth)):
            self.now = Filling(**newest["after"])
        self._publish()

    async def status(self) -> dict[str, Any]:
        return {
            "tip": self.now.tip,
            "volume": round(self.now.volume_ul, 3),
            "tips_left": self.now.tips_left,
        }

    async def safe(self) -> None:
        self._held.set()

    async def pick_up_tip(self, goal: GoalContext) -> dict[str, Any]:
        if self.now.tip:
            raise ActionFailed("TipAlready", "a tip is on already: eject it first")
        if not self.now.tips_left:
            raise ActionFailed("RackEmpty", "no tip is left in the rack")
        await self._wait(TIP_S)
        with self.failing("pick_up_tip", goal):
            after = replace(self.now, tip=True, tips_left=self.now.tips_left - 1)
            self._become(after, "pick_up_tip", goal)
        return {"tips_left": self.now.tips_left}

    async def aspirate(self, goal: GoalContext, *, volume: float) -> dict[str, Any]:
        self._need_tip()
        if self.now.volume_ul + volume > FULL_UL:
            raise ActionFailed(
                "TipFull", f"{self.now.volume_ul:g} + {volume:g} uL; the tip holds {FULL_UL:g} uL"
            )
        await self._wait(STROKE_S)
        with self.failing("aspirate", goal):
            drawn = min(self._true_volume(volume, goal), self.now.reservoir_ul)
            after = replace(
                self.now,
                volume_ul=self.now.volume_ul + volume,
                held_ul=self.now.held_ul + drawn,
                reservoir_ul=self.now.reservoir_ul - drawn,
            )
            self._become(after, "aspirate", goal)
        if drawn < volume / 2:
            raise ActionFailed(
                "NoLiquid", f"only {drawn:.1f} of {volume:g} uL were left; air was drawn"
            )
        return {"volume": round(self.now.volume_ul, 3)}

    async def dispense(self, goal: GoalContext, *, volume: float) -> dict[str, Any]:
        self._need_tip()
        if volume > self.now.volume_ul + 1e-6:
            raise ActionFailed(
                "TooLittle", f"the tip holds {self.now.volume_ul:g} uL of {volume:g}"
            )
        await self._wait(STROKE_S)
        with self.failing("dispense", goal):
            last = volume > self.now.volume_ul - 1e-6  # the plunger goes to its end
            pushed = self.now.held_ul if last else self._true_volume(volume, goal)
            pushed = min(pushed, self.now.held_ul)
            after = replace(
                self.now,
                volume_ul=max(0.0, self.now.volume_ul - volume),
                held_ul=self.now.held_ul - pushed,
                dropped_mg=self.now.dropped_mg + pushed * MG_PER_UL,
            )
            self._become(after, "dispense", goal)
        return {"volume": round(self.now.volume_ul, 3)}

    async def last_stroke(self, goal: GoalContext) -> dict[str, Any]:
        return {
            "goal_id": self.now.goal or "",  # its memory outlives a kill: empty means never
            "action": self.now.action,
            "volume": round(self.now.volume_ul, 3),
            "tips_left": self.now.tips_left,
        }

    async def eject_tip(self, goal: GoalContext) -> dict[str, Any]:
        await self._wait(EJECT_S)
        with self.failing("eject_tip", goal):
            if self.now.tip:
                after = replace(self.now, tip=False, volume_ul=0.0, held_ul=0.0)
                self._become(after, "eject_tip", goal)
        return {}

    async def hold(self, goal: GoalContext) -> dict[str, Any]:
        return {}  # one goal at a time: no stroke is under way when this one begins

    async def _wait(self, seconds: float) -> None:
        self._held.clear()
        if await self.clock.sleep_unless(self._held, seconds):
            raise ActionFailed("Rejected", "the pipette was stopped before the stroke", "no")

    def _need_tip(self) -> None:
        if not self.now.tip:
            raise ActionFailed("NoTip", "no tip is on: pick one up first")

    def _true_volume(self, volume: float, goal: GoalContext) -> float:
        random = Random(f"{self.seed}/{goal.id}")
        error = random.gauss(BIAS, SPREAD) * volume + random.gauss(0, LEAST_UL)
        return max(0.0, volume + error)

    def _become(self, after: Filling, action: str, goal: GoalContext) -> None:
        """The instant of the stroke: from here on it has happened."""
        after = replace(after, action=action, goal=goal.id)
        self.truth.append(action, goal=goal.id, after=asdict(after))
        self.now = after
        self._publish()

    def _publish(self) -> None:
        self.world.publish(self.place.device, {"dropped_mg": self.now.dropped_mg})
