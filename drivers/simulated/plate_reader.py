"""A simulated plate reader over the wells that a simulated dispenser fills.

Configuration: `dispenser` (by its name in the lab), `absorbs` (liquid -> absorbance of 1 cm of it at its
peak), `peak_nm`.

The beam goes from above, so it sees all that is in a well and not how dilute that is: water that is
added or evaporates does not matter (OpenWetWare measured it on a Victor3), 5 uL more of a dye do. The
plate itself absorbs some 0.04. A thousandth of the light goes past the sample, so that nothing reads
more than 3, and everything above 2 to 2.5 too little, without any sign of it (Molecular Devices,
Biochrom on stray light).
"""

import math
from random import Random
from typing import Any, ClassVar

from ..driver import ActionCanceled, GoalContext, Place
from .twins.twin import Twin

AREA_CM2, PLATE = 0.34, 0.04
STRAY, NOISE = 1e-3, 3e-5  # of the light that goes in
PEAK_NM, WIDTH_NM = 450.0, 40.0
READ_S = 1.5


class SimPlateReader(Twin):
    """Implements plate_reader@1."""

    contract: ClassVar[str] = "plate_reader@1"
    options: ClassVar[tuple[str, ...]] = ("dispenser", "absorbs", "peak_nm")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.reading: str | None = None

    async def status(self) -> dict[str, Any]:
        return {"reading": self.reading}

    async def read(
        self, goal: GoalContext, *, well: str, wavelength: float = PEAK_NM
    ) -> dict[str, Any]:
        with self.failing("read", goal):
            self.reading = well
            stopped = await self.clock.sleep_unless(goal.cancelled, READ_S)
            self.reading = None
            if stopped:
                raise ActionCanceled("the reading was stopped")
            truly = self.absorbance(well, wavelength)
            through = (10**-truly + STRAY) / (1 + STRAY)
            noise = Random(f"{self.seed}/{goal.id}").gauss(0, NOISE * (1 + 30 * through))
            shown = -math.log10(max(1e-4, through + noise))
            self.truth.append("read", goal=goal.id, well=well, absorbance=truly, shown=shown)
        return {"absorbance": round(shown, 4)}

    def absorbance(self, well: str, wavelength_nm: float = PEAK_NM) -> float:
        """What a perfect reader would show for a well."""
        filled = self.world.look(self.config.get("dispenser", "dispenser")) or {"vessels": {}}
        peak_nm = float(self.config.get("peak_nm", PEAK_NM))
        share = math.exp(-(((wavelength_nm - peak_nm) / WIDTH_NM) ** 2) / 2)
        absorbs = self.config.get("absorbs", {})
        held_ul = filled["vessels"].get(well, {})
        way = sum(float(absorbs.get(one, 0)) * volume for one, volume in held_ul.items()) / 1000
        return PLATE + share * way / AREA_CM2
