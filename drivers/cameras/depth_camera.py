"""What all depth cameras share: take a look, and measure in it. How to look is up to each driver."""

import asyncio
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, ClassVar

from ...schemas.messages import FileContent
from ..driver import ActionFailed, Driver, GoalContext, Place
from .vision import measure
from .vision.board import Board

if TYPE_CHECKING:
    from .vision.pose import Calibration
    from .vision.view import View


class DepthCamera(Driver):
    """The actions of depth_camera@1, for drivers that implement `look`."""

    contract: ClassVar[str] = "depth_camera@1"
    extra: ClassVar[str | None] = "vision"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.calibration: Calibration | None = None
        self.calibrated_by: str | None = ""
        """The goal that asked for it; empty where nothing is kept, None where that is not known."""

    async def look(self, action: str, goal: GoalContext) -> "View":
        """What the camera sees now, for this action; raises ActionFailed."""
        raise NotImplementedError

    def keep(self, fit: "Calibration", goal: GoalContext) -> None:
        """Store where the camera is, so that it outlives this process."""
        raise NotImplementedError

    async def worked(self, work: Callable[..., Any], *about: Any) -> Any:
        """Run seconds of computation in a thread, so that the server keeps responding."""
        return await asyncio.to_thread(work, *about)

    def need_calibration(self) -> "Calibration":
        """Where the camera is; raises ActionFailed if that is unknown."""
        if self.calibration is None:
            raise ActionFailed("NotCalibrated", "the camera's position is unknown: calibrate it")
        return self.calibration

    async def capture(
        self, goal: GoalContext, *, image: str, depth: str | None = None, above: bool = False
    ) -> dict[str, Any]:
        fit = self.need_calibration() if above else None
        view = await self.look("capture", goal)
        told: dict[str, Any] = {
            "image": image, "width": view.eye.width, "height": view.eye.height,
        }  # fmt: skip
        if fit is None:
            picture = await self.worked(measure.picture_file, view, image)
        else:
            picture, place = await self.worked(measure.above_file, view, fit, image)
            told |= place
        goal.files["image"] = FileContent.of(image, picture)
        if depth is not None:
            far = await self.worked(measure.depth_png, view)
            goal.files["depth"] = FileContent.of(depth, far)
            told["depth"] = depth
        return told

    async def calibrate(
        self,
        goal: GoalContext,
        *,
        columns: int = 9,
        rows: int = 6,
        square: float = 25.0,
        x: float = 0.0,
        y: float = 0.0,
        angle: float = 0.0,
        thickness: float = 0.0,
        touched: Sequence[dict[str, Any]] = (),
        touch_error: float = measure.TOUCH_SD_MM,
    ) -> dict[str, Any]:
        view = await self.look("calibrate", goal)
        board = Board(columns, rows, square, x, y, angle, thickness)
        fit = await self.worked(measure.calibrate, view, board, touched, touch_error)
        self.keep(fit, goal)
        self.calibration, self.calibrated_by = fit, goal.id
        return _told(fit)

    async def last_calibration(self, goal: GoalContext) -> dict[str, Any]:
        told = {} if self.calibration is None else _told(self.calibration)
        return {"goal_id": self.calibrated_by, **told}

    async def locate_point(
        self, goal: GoalContext, *, u: float, v: float, height: float | None = None
    ) -> dict[str, Any]:
        fit = self.need_calibration()
        view = await self.look("locate_point", goal)
        return await self.worked(measure.locate, view, fit, u, v, height)

    async def locate_samples(
        self,
        goal: GoalContext,
        *,
        min_height: float = 3.0,
        min_area: float = 100.0,
        flat: bool = True,
    ) -> dict[str, Any]:
        fit = self.need_calibration()
        view = await self.look("locate_samples", goal)
        return {
            "samples": await self.worked(measure.outlines, view, fit, min_height, min_area, flat)
        }


def _told(fit: "Calibration") -> dict[str, Any]:
    where = (round(float(value), 3) for value in fit.pose.place_mm)
    return {
        "rms": round(fit.rms_px, 4), **dict(zip("xyz", where, strict=True)),
        "tilt": round(fit.pose.tilt_deg, 3), "board_x": round(fit.board.x_mm, 3),
        "board_y": round(fit.board.y_mm, 3), "board_angle": round(fit.board.angle_deg, 3),
    }  # fmt: skip
