"""A simulated furnace with its controller: it overshoots, cools slower than it heats, and goes on alone.

Configuration: `start_c` (how warm it is at first), `sensor_breaks_after_s`.

What a programmer would not think of: the controller's set point creeps along the ramp, and waits for a
furnace that cannot follow ("holdback", Eurotherm's glossary). On the way down that is always so below a few
hundred °C, since heat only goes through the walls. The integral of a PI controller that has learnt the
ramp carries the furnace some K beyond its end. A computer that dies stops nothing. Where the thermocouple
breaks the heater goes off (the `S.br` of Carbolite's controllers).
"""

import time
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar

from ..driver import ActionCanceled, ActionFailed, GoalContext, Place
from .twins.twin import Twin

ROOM_C = 20.0
FULL_POWER_K, WALLS_S, ELEMENT_S = 3000.0, 10_800.0, 90.0  # rise at full power; time constants
GAIN_PER_K, INTEGRAL_S = 0.02, 900.0
HOLDBACK_K = 15.0
STEP_S, LOOK_S, KEEP_S = 1.0, 10.0, 60.0
STILL_S = 300.0


@dataclass(slots=True)
class Heat:
    """The furnace and its controller at one moment; kept in the world, as they outlive a server."""

    temperature_c: float
    state: str = "off"
    set_point_c: float = ROOM_C
    target_c: float = ROOM_C
    k_per_s: float = 0.0
    within_k: float = 2.0
    near_s: float = 0.0
    power: float = 0.0
    flow: float = 0.0
    integral: float = 0.0
    highest_c: float = ROOM_C
    hold: dict[str, Any] = field(default_factory=lambda: {"goal_id": "", "s": 0.0})


class SimFurnace(Twin):
    """Implements furnace@1."""

    contract: ClassVar[str] = "furnace@1"
    options: ClassVar[tuple[str, ...]] = ("start_c", "sensor_breaks_after_s")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.now = Heat(float(self.config.get("start_c", ROOM_C)))
        self._at_s = self._kept_s = self._began_s = 0.0

    async def open(self) -> None:
        await super().open()
        self._at_s = self._kept_s = self._began_s = self.clock.now_s()
        if kept := self.world.look(self.place.device):
            self.now = Heat(**kept["heat"])
            if not self.clock.leaps:
                self._at_s -= (time.time() - kept["at"]) * self.clock.speed

    async def status(self) -> dict[str, Any]:
        self._catch_up()
        self._check_sensor()
        now = self.now
        return {
            "temperature": round(now.temperature_c, 1),
            "set_point": None if now.state == "off" else round(now.set_point_c, 1),
            "power": round(100 * now.power, 1),
            "state": now.state,
        }

    async def safe(self) -> None:
        self._catch_up()
        self._switch_off()

    async def off(self, goal: GoalContext) -> dict[str, Any]:
        with self.failing("off", goal):
            await self.safe()
            self.truth.append("off", goal=goal.id, temperature_c=self.now.temperature_c)
        return {}

    async def ramp(
        self, goal: GoalContext, *, to: float, rate: float, within: float = 2.0
    ) -> dict[str, Any]:
        with self.failing("ramp", goal):
            self._catch_up()
            now = self.now
            if now.state == "off":
                now.set_point_c, now.integral = now.temperature_c, now.flow
            now.state, now.target_c, now.k_per_s, now.within_k = "ramping", to, rate / 60, within
            now.highest_c = now.temperature_c
            if abs(now.temperature_c - to) > within:
                now.near_s = 0.0
            self._keep()
            while now.near_s < STILL_S:
                await self._look(goal)
                goal.feedback(None, f"{now.temperature_c:.1f} °C")
            self.now.state = "holding"
            self.truth.append("ramp", goal=goal.id, to=to, highest_c=now.highest_c)
        return {"temperature": round(now.temperature_c, 1), "highest": round(now.highest_c, 1)}

    async def hold(self, goal: GoalContext, *, duration: float) -> dict[str, Any]:
        self._catch_up()
        now = self.now
        if now.state == "off":
            raise ActionFailed("Cold", f"it is off, at {now.temperature_c:.0f} °C: ramp first")
        with self.failing("hold", goal):
            now.state, here = "holding", now.temperature_c
            now.hold = {"goal_id": goal.id, "s": 0.0, "low": here, "high": here, "sum": 0.0}
            self.truth.append("hold", goal=goal.id, duration_s=duration)
            self._keep()
            while now.hold["s"] < duration:
                await self._look(goal, duration - now.hold["s"])
                goal.feedback(now.hold["s"] / duration, f"{now.temperature_c:.1f} °C")
            self._keep()
        return self._held()

    async def last_hold(self, goal: GoalContext) -> dict[str, Any]:
        self._catch_up()
        return {"goal_id": self.now.hold["goal_id"], **(self._held() if self.now.hold["s"] else {})}

    def _held(self) -> dict[str, Any]:
        held = self.now.hold
        mean = held["sum"] / held["s"]
        named = {"lowest": held["low"], "mean": mean, "highest": held["high"]}
        return {"held": round(held["s"], 1), **{n: round(v, 1) for n, v in named.items()}}

    async def _look(self, goal: GoalContext, at_most_s: float = LOOK_S) -> None:
        """Let a little time pass; raises where what was asked for is over."""
        if await self.clock.sleep_unless(goal.cancelled, min(LOOK_S, at_most_s)):
            self._catch_up()
            self.now.target_c, self.now.state = self.now.set_point_c, "holding"
            self._keep()
            raise ActionCanceled(f"it stays at {self.now.set_point_c:.0f} °C")
        self._catch_up()
        self._check_sensor()
        if self.now.state == "off":
            raise ActionFailed("SwitchedOff", f"it is off, at {self.now.temperature_c:.0f} °C")

    def _check_sensor(self) -> None:
        breaks_s = float(self.config.get("sensor_breaks_after_s", "inf"))
        if self.clock.now_s() - self._began_s > breaks_s:
            self._switch_off()
            raise ActionFailed("SensorBroken", "the controller shows S.br; its heater is off")

    def _switch_off(self) -> None:
        self.now.state, self.now.power = "off", 0.0
        self._keep()

    def _keep(self) -> None:
        self._kept_s = self.clock.now_s()
        self.world.publish(self.place.device, {"at": time.time(), "heat": asdict(self.now)})

    def _catch_up(self) -> None:
        """What furnace and controller have done since somebody last looked."""
        until_s = self.clock.now_s()
        while self._at_s < until_s:
            step_s = min(STEP_S, until_s - self._at_s)
            self._at_s += step_s
            _control(self.now, step_s)
            _warm(self.now, step_s)
        if until_s - self._kept_s > KEEP_S:
            self._keep()


def _control(now: Heat, step_s: float) -> None:
    """The controller: its set point on the ramp, and a PI whose power is between nothing and all."""
    if now.state == "off":
        return
    left_k, behind_k = now.target_c - now.set_point_c, now.set_point_c - now.temperature_c
    if behind_k * left_k <= 0 or abs(behind_k) < HOLDBACK_K:
        now.set_point_c += max(-now.k_per_s * step_s, min(now.k_per_s * step_s, left_k))
    error_k = now.set_point_c - now.temperature_c
    wanted = GAIN_PER_K * error_k + now.integral
    if 0 < wanted < 1 or wanted * error_k < 0:
        now.integral += GAIN_PER_K * error_k * step_s / INTEGRAL_S
    now.power = max(0.0, min(1.0, wanted))


def _warm(now: Heat, step_s: float) -> None:
    """The furnace: heat comes through the element, and goes through the walls."""
    now.flow += (now.power - now.flow) * step_s / (ELEMENT_S + step_s)
    now.temperature_c += (FULL_POWER_K * now.flow + ROOM_C - now.temperature_c) * step_s / WALLS_S
    near = abs(now.temperature_c - now.target_c) <= now.within_k
    now.near_s = now.near_s + step_s if near else 0.0
    now.highest_c = max(now.highest_c, now.temperature_c)
    if now.state == "holding" and "sum" in now.hold:
        held = now.hold
        held["s"] += step_s
        held["sum"] += now.temperature_c * step_s
        held["low"] = min(held["low"], now.temperature_c)
        held["high"] = max(held["high"], now.temperature_c)
