"""A simulated colour camera: dyes that a dispenser has mixed, in white light from below.

Configuration: `dispenser` (the device whose vessels it sees, by its name in the lab), `depth_mm` (of the
liquid that the light passes).
"""

import math
from random import Random
from typing import Any, ClassVar

from ..driver import ActionFailed, GoalContext, Place
from .dispenser import UNDER_THE_OUTLET
from .twins.twin import Twin

ABSORBS = {"red": (0.06, 1.0, 0.75), "yellow": (0.02, 0.12, 1.1), "blue": (1.1, 0.45, 0.08)}
"""Dye -> absorbance of red, green and blue light by 10 mm of the dye as it comes from its bottle."""
DEPTH_MM, LOOK_S = 10.0, 1.0
WHITE, FLICKER = 250.0, 0.8
GAMMA = 2.2


class SimColourCamera(Twin):
    """Implements colour_camera@1."""

    contract: ClassVar[str] = "colour_camera@1"
    options: ClassVar[tuple[str, ...]] = ("dispenser", "depth_mm")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.depth_mm = float(self.config.get("depth_mm", DEPTH_MM))

    async def status(self) -> dict[str, Any]:
        return {"connected": True}

    async def look(self, goal: GoalContext, *, into: str | None = None) -> dict[str, Any]:
        await self.clock.sleep(LOOK_S)
        with self.failing("look", goal):
            dispenser = self.config.get("dispenser", "dispenser")
            vessels = (self.world.look(dispenser) or {"vessels": {}})["vessels"]
            vessel = UNDER_THE_OUTLET if into is None else into
            held = vessels.get(vessel, {})
            if not sum(held.values()):
                raise ActionFailed("Nothing", f"there is nothing in {vessel}")
            random = Random(f"{self.seed}/{goal.id}")
            seen = [value + random.gauss(0, FLICKER) for value in colour(held, self.depth_mm)]
            red, green, blue = (round(min(max(value, 0.0), 255.0), 2) for value in seen)
        return {"red": red, "green": green, "blue": blue, "spread": FLICKER}


def colour(held_ul: dict[str, float], depth_mm: float = DEPTH_MM) -> tuple[float, float, float]:
    """Red, green and blue of a mixture by the law of Beer and Lambert; all but the dyes is clear."""
    total = math.fsum(held_ul.values())
    light = []
    for channel in range(3):
        dyes = ((ABSORBS[name][channel], v) for name, v in held_ul.items() if name in ABSORBS)
        absorbance = math.fsum(strength * v for strength, v in dyes) / total * depth_mm / 10
        light.append(WHITE * 10 ** (-absorbance / GAMMA))
    return light[0], light[1], light[2]
