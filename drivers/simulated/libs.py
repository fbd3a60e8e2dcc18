"""A simulated LIBS analyser: it fires at the simulated core where the gantry holds it.

Configuration: `gantry` (the device that carries it, by its name in the lab), `core` (the core's
seed), `interlock` (closed or open). Without such a gantry, it is at the origin.
"""

import asyncio
import math
from typing import TYPE_CHECKING, Any, ClassVar

from ...schemas.messages import FileContent
from ...system.extras import not_installed
from ..driver import ActionFailed, GoalContext, Place
from .twins.twin import Twin

if TYPE_CHECKING:
    from .twins.shot import ShotMaker

PURGE_S, READOUT_S = 6.0, 2.0
EXPORT_S, LOCATE_S, RECONNECT_S = 5.0, 10.0, 20.0
FOCUS_MM = 1.0  # how far from the surface e^-0.5 of the light is left
FAINT = 0.02  # of the light in focus; less is no signal


class SimLibs(Twin):
    """Implements libs_analyzer@1.

    The log of the truth is its memory, as a shot's line is written at the instant it is fired; its
    spectrum is computed from that line on request, always the same.
    """

    contract: ClassVar[str] = "libs_analyzer@1"
    options: ClassVar[tuple[str, ...]] = ("gantry", "core", "interlock")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.armed = False
        self.argon_bar = 1.1
        self._disarmed = asyncio.Event()
        self.shots: ShotMaker | None = None
        self.lacking = ""

    async def open(self) -> None:
        await super().open()
        # Here and not above: numpy and the tables are of no use to those who only read the class.
        try:
            from .twins.shot import ShotMaker
        except ImportError as fault:  # what needs no shot does without
            self.lacking = not_installed(fault, "numpy") or str(fault)
        else:
            self.shots = ShotMaker(int(self.config.get("core", 3)), self.seed)

    def interlock(self) -> str:
        """Of the enclosure: closed or open."""
        return self.config.get("interlock", "closed")

    async def status(self) -> dict[str, Any]:
        return {
            "armed": self.armed,
            "shots": len(self.truth),
            "interlock": self.interlock(),
            "argon": round(self.argon_bar, 3),
        }

    async def safe(self) -> None:
        self.armed = False
        self._disarmed.set()

    async def measure(self, goal: GoalContext) -> dict[str, Any]:
        if self.shots is None:
            raise ActionFailed("Rejected", f"no shot can be simulated: {self.lacking}", "no")
        self.armed = True
        self._disarmed.clear()
        self.argon_bar = 1.1 - 0.04 * math.sin(len(self.truth))  # the valve swings a little
        locked = await self.clock.sleep_unless(self._disarmed, PURGE_S)
        if locked or self.interlock() == "open":
            raise ActionFailed("Rejected", "the laser was locked before it fired", "no")
        with self.failing("measure", goal):
            shot = self._fire(goal)
            await self.clock.sleep(READOUT_S)
        if shot["focus"] < FAINT:
            raise ActionFailed("NoSignal", _no_signal(shot))
        return {"shot_id": shot["shot"]}

    async def last_shot(self, goal: GoalContext) -> dict[str, Any]:
        # Null would say "I cannot know"; a memory that outlives a kill and is empty does know.
        newest = self.truth.entry(len(self.truth)) or {"goal": ""}
        return {"shot_id": newest.get("shot"), "goal_id": newest["goal"]}

    async def export(self, goal: GoalContext, *, shot: str, file: str) -> dict[str, Any]:
        kept = self._kept(shot)
        if kept is None or self.shots is None:
            raise ActionFailed("UnknownShot", self.lacking or f"the analyser has no shot {shot!r}")
        await self.clock.sleep(EXPORT_S)
        with self.failing("export", goal):
            shots = self.shots
            data = self.world.content(lambda: shots.csv(kept))
            goal.files["file"] = sent = FileContent.of(file, data)
        return {"file": file, "sha256": sent.sha256}

    async def disarm(self, goal: GoalContext) -> dict[str, Any]:
        await self.safe()
        return {}

    async def locate(self, goal: GoalContext) -> dict[str, Any]:
        with self.failing("locate", goal):
            await self.clock.sleep(LOCATE_S)
        return {}

    async def reconnect(self, goal: GoalContext) -> dict[str, Any]:
        await self.clock.sleep(RECONNECT_S)
        return {}

    def _fire(self, goal: GoalContext) -> dict[str, Any]:
        """The instant of the shot: from here on it has happened."""
        assert self.shots is not None  # `measure` has looked
        place = self.world.look(self.config.get("gantry", "gantry")) or {"x": 0, "y": 0, "z": 0}
        x, y, z = (round(float(place[axis]), 4) for axis in "xyz")
        mineral, height = self.shots.surface(x, y)
        focus = math.exp(-(((z - height) / FOCUS_MM) ** 2) / 2) if mineral else 0.0
        return self.truth.append(
            "shot",
            shot=f"shot-{len(self.truth) + 1:06d}",
            goal=goal.id,
            x=x, y=y, z=z,
            focus=round(focus, 5),
            mineral=mineral,
            elapsed_s=round(self.clock.elapsed_s, 3),
        )  # fmt: skip

    def _kept(self, shot: str) -> dict[str, Any] | None:
        _, _, number = shot.rpartition("-")
        entry = self.truth.entry(int(number)) if number.isascii() and number.isdigit() else None
        return entry if entry and entry["shot"] == shot else None


def _no_signal(shot: dict[str, Any]) -> str:
    place = f"x {shot['x']:g} y {shot['y']:g} z {shot['z']:g} mm"
    if shot["mineral"] is None:
        return f"fired at {place}, where there is no sample: the simulated core is 48 x 120 mm"
    return f"fired at {place}, out of focus: the surface is near z 0 mm"
