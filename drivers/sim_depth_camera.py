"""A depth camera without hardware: it draws what two eyes would see, then measures in the pictures.

Configuration: `gantry` (the device that carries it, by its name in the lab; without it the camera
stands still), `place` (x, y, z in mm and tilt in degrees towards bench y: where the left eye is,
from the gantry's place or from bench zero), `board` (columns, rows, square, x, y: the chessboard
that lies on the bench, null for none), `stones` ([x, y, width, length, height] each), `core` (the
seed of the analyser's core), `trouble` (covered, blurred, mirrored, shaken or one_eyed).
"""

import asyncio
import math
from collections.abc import Callable
from hashlib import sha256
from typing import TYPE_CHECKING, Any, ClassVar

from ..schemas.messages import FileContent
from .driver import ActionFailed, GoalContext, Place
from .stereo import measure
from .stereo.board import Board
from .twins.camera import Eyes
from .twins.camera_trouble import TROUBLES
from .twins.faults import chance
from .twins.twin import Twin

if TYPE_CHECKING:
    import numpy as np

    from .stereo.pose import Calibration

CAPTURE_S, CALIBRATE_S, POINT_S, SAMPLES_S = 2.0, 5.0, 1.0, 3.0
MOVED_MM = 0.05  # further than that, and a calibration holds no more
SPOILED_BY = {
    "BoardNotFound": ("covered", "blurred"),
    "BoardMirrored": ("mirrored",),
    "PoorFit": ("shaken",),
    "NoDepth": ("one_eyed",),
}
"""An error that is ordered is not told but shown: the driver has to find it in the pictures."""


class SimDepthCamera(Twin):
    """Keeps depth_camera@1; its calibration outlives its server, as a file would."""

    contract: ClassVar[str] = "depth_camera@1"
    options: ClassVar[tuple[str, ...]] = ("gantry", "place", "board", "stones", "core", "trouble")

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.eyes = Eyes(self.config, self.world, self.seed)
        self.trouble = self.config.get("trouble")
        if self.trouble not in (None, *TROUBLES):
            raise ValueError(f"trouble is {self.trouble!r}; it is one of: {', '.join(TROUBLES)}")
        self.calibration: Calibration | None = None
        self.calibrated_at: list[float] = []

    async def open(self) -> None:
        await super().open()
        if kept := self.world.look(self.place.device):
            from .stereo.pose import Calibration

            self.calibration = Calibration.from_dict(kept["calibration"])
            self.calibrated_at = kept["at"]

    async def status(self) -> dict[str, Any]:
        rms = 0.0 if self.calibration is None else round(self.calibration.rms_px, 3)
        return {"connected": True, "calibrated": self.calibration is not None, "rms": rms}

    async def capture(
        self, goal: GoalContext, *, image: str, depth: str | None = None
    ) -> dict[str, Any]:
        await self.clock.sleep(CAPTURE_S)
        pair = await self._pictures("capture", goal)
        told: dict[str, Any] = {"image": image}
        self._give(goal, "image", image, await self._worked(measure.picture_png, pair))
        if depth is not None:
            data = await self._worked(measure.depth_png, pair, self.eyes.rig)
            self._give(goal, "depth", depth, data)
            told["depth"] = depth
        return {**told, "width": self.eyes.rig.width, "height": self.eyes.rig.height}

    async def calibrate(
        self,
        goal: GoalContext,
        *,
        columns: int = 9,
        rows: int = 6,
        square: float = 25.0,
        x: float = 0.0,
        y: float = 0.0,
    ) -> dict[str, Any]:
        await self.clock.sleep(CALIBRATE_S)
        at, truly = self.eyes.carriage_mm(), self.eyes.pose().place_mm.tolist()
        pair = await self._pictures("calibrate", goal)
        board = Board(columns, rows, square, x, y)
        fit = await self._worked(measure.calibrate, pair, board, self.eyes.rig)
        self.calibration, self.calibrated_at = fit, at
        self.truth.append("calibrate", goal=goal.id, place=truly, rms_px=fit.rms_px)
        self.world.publish(self.place.device, {"calibration": fit.to_dict(), "at": at})
        where = (round(float(value), 3) for value in fit.pose.place_mm)
        tilt = round(fit.pose.tilt_deg, 3)
        return {"rms": round(fit.rms_px, 4), **dict(zip("xyz", where, strict=True)), "tilt": tilt}

    async def locate_point(
        self, goal: GoalContext, *, u: float, v: float, height: float | None = None
    ) -> dict[str, Any]:
        fit, rig = self._need_calibration(), self.eyes.rig
        if not rig.holds(u, v):
            size = f"{rig.width} x {rig.height}"
            raise ActionFailed("OutsidePicture", f"{u:g}, {v:g} is not in a picture of {size}")
        await self.clock.sleep(POINT_S)
        pair = await self._pictures("locate_point", goal)
        return await self._worked(measure.locate, pair, fit, rig, u, v, height)

    async def locate_samples(
        self, goal: GoalContext, *, min_height: float = 3.0, min_area: float = 100.0
    ) -> dict[str, Any]:
        fit = self._need_calibration()
        await self.clock.sleep(SAMPLES_S)
        pair = await self._pictures("locate_samples", goal)
        wanted = pair, fit, self.eyes.rig, min_height, min_area
        return {"samples": await self._worked(measure.outlines, *wanted)}

    async def _pictures(self, action: str, goal: GoalContext) -> tuple["np.ndarray", "np.ndarray"]:
        """What both eyes see now, with the trouble that was ordered."""
        trouble, fault = self.trouble, self.faults.drawn(action, goal.id)
        if fault is not None:
            if fault.error not in SPOILED_BY:
                raise fault.failure()
            kinds = SPOILED_BY[fault.error]
            trouble = kinds[int(chance(self.seed, "trouble", goal.id) * len(kinds))]
        return await self._worked(self.eyes.look, goal.id, trouble)

    async def _worked(self, work: Callable[..., Any], *about: Any) -> Any:
        """What takes seconds of a processor, in a thread: the server goes on answering meanwhile.

        In a rehearsal time leaps whenever the loop waits, also for a thread; so it does not wait.
        """
        if self.config.get("clock") == "rehearsal":
            return work(*about)
        return await asyncio.to_thread(work, *about)

    @staticmethod
    def _give(goal: GoalContext, name: str, path: str, data: bytes) -> None:
        goal.files[name] = FileContent(path=path, sha256=sha256(data).hexdigest(), data=data)

    def _need_calibration(self) -> "Calibration":
        if self.calibration is None:
            raise ActionFailed(
                "NotCalibrated", "the camera does not know where it is: calibrate it"
            )
        moved = math.dist(self.eyes.carriage_mm(), self.calibrated_at)
        if moved > MOVED_MM:
            raise ActionFailed(
                "NotCalibrated",
                f"the camera was moved by {moved:.2f} mm since it was calibrated: calibrate again",
            )
        return self.calibration
