"""A simulated microscope on a simulated gantry: it is sharp where the lens is at the right height.

Configuration: `gantry` (the device that carries it, by its name in the lab), `focus_mm` (the gantry's z
where the sample is sharp at the bench's zero), `rise` (how the sample lies: mm in z for a mm in x and in
y).

Sharpness is the variance of a Laplacian, which falls as a bell around the focus (compared with other
measures by Groen, Young and Ligthart, Cytometry 6:81, 1985; Pech-Pacheco, ICPR 2000). It also depends on
what is seen: a smooth place in focus has less of it than a rough one out of focus, so only a sweep at
one place tells the focus. Far from the focus the camera's own noise is left, which is no hint of the
way.
"""

import math
from random import Random
from typing import Any, ClassVar

from ..driver import GoalContext, Place
from .twins.twin import Twin

FULL, FLOOR = 100.0, 4.0
DEPTH_MM, NOISE = 0.12, 0.015
LOOK_S = 0.5


class SimMicroscope(Twin):
    """Implements microscope@1."""

    contract: ClassVar[str] = "microscope@1"
    options: ClassVar[tuple[str, ...]] = ("gantry", "focus_mm", "rise")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.shown = 0.0

    async def status(self) -> dict[str, Any]:
        return {"sharpness": round(self.shown, 2)}

    async def look(self, goal: GoalContext) -> dict[str, Any]:
        await self.clock.sleep(LOOK_S)
        with self.failing("look", goal):
            place = self.world.look(self.config.get("gantry", "gantry")) or {"x": 0, "y": 0, "z": 0}
            x, y, z = (float(place[axis]) for axis in "xyz")
            off = (z - self.focus_mm(x, y)) / DEPTH_MM
            sharp = FULL * _texture(x, y) * math.exp(-(off**2) / 2)
            noise = Random(f"{self.seed}/{goal.id}").gauss(1, NOISE)
            self.shown = (sharp + FLOOR) * noise
            self.truth.append("look", goal=goal.id, x=x, y=y, z=z, off_mm=off * DEPTH_MM)
        return {"sharpness": round(self.shown, 2)}

    def focus_mm(self, x: float, y: float) -> float:
        """The gantry's z at which the sample is sharp at a place."""
        rise_x, rise_y = self.config.get("rise", [0.02, 0.01])
        return float(self.config.get("focus_mm", 20.0)) + rise_x * x + rise_y * y


def _texture(x: float, y: float) -> float:
    """How much there is to see at a place, about 1."""
    return 1 + 0.25 * math.sin(1.7 * x + 0.4) * math.cos(1.1 * y)
