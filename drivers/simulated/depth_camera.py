"""A simulated depth camera: it draws what two eyes would see, then measures in the pictures.

Configuration: `gantry` (the device that carries it, by its name in the lab; without it the camera
stands still), `place` (x, y, z in mm and tilt in degrees towards bench y: where the left eye is,
from the gantry's place or from bench zero), `board` (columns, rows, square, x, y: the chessboard
that lies on the bench, null for none), `stones` ([x, y, width, length, height] each), `core` (the
seed of the analyser's core), `trouble` (covered, blurred, mirrored, shaken or one_eyed).
"""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ClassVar

from ..cameras.depth_camera import DepthCamera
from ..driver import ActionFailed, GoalContext, Place
from .twins.camera import Eyes
from .twins.camera_trouble import TROUBLES
from .twins.faults import chance
from .twins.twin import Twin

if TYPE_CHECKING:
    from ..cameras.vision.pose import Calibration
    from ..cameras.vision.view import View

TAKES_S = {"capture": 2.0, "calibrate": 5.0, "locate_point": 1.0, "locate_samples": 3.0}
MOVED_MM = 0.05  # beyond this, a calibration is no longer valid
SPOILED_BY = {
    "BoardNotFound": ("covered", "blurred"),
    "BoardMirrored": ("mirrored",),
    "PoorFit": ("shaken",),
    "NoDepth": ("one_eyed",),
}
"""An injected error is not reported but drawn: the driver has to find it in the pictures."""


class SimDepthCamera(Twin, DepthCamera):
    """Implements depth_camera@1; its calibration outlives its server, as a file would."""

    contract: ClassVar[str] = "depth_camera@1"
    options: ClassVar[tuple[str, ...]] = ("gantry", "place", "board", "stones", "core", "trouble")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.eyes = Eyes(self.config, self.world, self.seed)
        self.trouble = self.config.get("trouble")
        if self.trouble not in (None, *TROUBLES):
            raise ValueError(
                f"trouble is {self.trouble!r}; it must be one of: {', '.join(TROUBLES)}"
            )
        self.looked_from: list[float] = []
        self.calibrated_at: list[float] = []

    async def open(self) -> None:
        await super().open()
        if kept := self.world.look(self.place.device):
            from ..cameras.vision.pose import Calibration

            self.calibration = Calibration.from_dict(kept["calibration"])
            self.calibrated_at, self.calibrated_by = kept["at"], kept.get("goal")

    async def status(self) -> dict[str, Any]:
        rms = 0.0 if self.calibration is None else round(self.calibration.rms_px, 3)
        return {"connected": True, "calibrated": self.calibration is not None, "rms": rms}

    async def look(self, action: str, goal: GoalContext) -> "View":
        """What both eyes see now, with the injected trouble."""
        await self.clock.sleep(TAKES_S[action])
        trouble, fault = self.trouble, self.faults.drawn(action, goal.id)
        if fault is not None:
            if fault.error not in SPOILED_BY:
                raise fault.failure()
            kinds = SPOILED_BY[fault.error]
            trouble = kinds[int(chance(self.seed, "trouble", goal.id) * len(kinds))]
        self.looked_from = self.eyes.carriage_mm()
        return await self.worked(self.eyes.look, goal.id, trouble)

    def keep(self, fit: "Calibration", goal: GoalContext) -> None:
        truly = self.eyes.pose().place_mm.tolist()
        self.calibrated_at = self.looked_from
        self.world.publish(
            self.place.device,
            {"calibration": fit.to_dict(), "at": self.looked_from, "goal": goal.id},
        )
        self.truth.append("calibrate", goal=goal.id, place=truly, rms_px=fit.rms_px)

    def need_calibration(self) -> "Calibration":
        fit = super().need_calibration()
        moved = math.dist(self.eyes.carriage_mm(), self.calibrated_at)
        if moved > MOVED_MM:
            raise ActionFailed(
                "NotCalibrated",
                f"the camera has moved by {moved:.2f} mm since it was calibrated: calibrate again",
            )
        return fit

    async def worked(self, work: Callable[..., Any], *about: Any) -> Any:
        """In a rehearsal time leaps whenever the loop waits, even for a thread, so do not wait."""
        if self.config.get("clock") == "rehearsal":
            return work(*about)
        return await super().worked(work, *about)
