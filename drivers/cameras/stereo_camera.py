"""A depth camera over the bench: a stereo camera on USB, or a folder that another program fills.

Configuration: `camera` (the file of its lens or lenses: `labrun calibrate-camera`, OpenCV, or a
ZED's .conf), and either `device` (a number, /dev/video2, rtsp://..., a film) with `size` ([width,
height] to request), or `folder` with `depth_unit` (one step of its depth maps in mm, default 0.1).
`x_runs` is the direction of bench x in the picture: right (the default), up, left or down.
A picture twice as wide as one eye's holds both eyes side by side.
"""

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from ...system.files import write_whole
from ..driver import ActionFailed, GoalContext, Place
from .depth_camera import DepthCamera
from .folder import CameraFolder, Shot
from .video import CameraVideo
from .vision.board import RUNS

if TYPE_CHECKING:
    from .vision.camera import Camera
    from .vision.pose import Calibration
    from .vision.view import View

OPTIONS = ("camera", "device", "folder", "size", "depth_unit", "x_runs")
KEPT = "calibration.json"


class StereoCamera(DepthCamera):
    """Implements depth_camera@1; the camera's position is kept in a file and outlives its server.

    The camera must stay still: a move is not detected. Recalibrate after any move.
    """

    contract: ClassVar[str] = "depth_camera@1"

    def __init__(self, place: Place) -> None:
        super().__init__(place)
        self.source = _source(place.config)
        self.x_runs = str(place.config.get("x_runs", "right"))
        if self.x_runs not in RUNS:
            raise ValueError(f"x_runs is {self.x_runs!r}; it must be one of: {', '.join(RUNS)}")
        self.file = Path(str(place.config["camera"]))
        self.cameras: tuple[Camera, ...] = ()
        self.connected = False

    async def open(self) -> None:
        from .vision.camera_file import read_cameras

        try:
            self.cameras = await self.worked(read_cameras, self.file)
        except ValueError as fault:
            raise OSError(str(fault)) from fault
        await self.worked(self.source.open)
        self.connected = True
        self.calibration = self._kept()

    async def close(self) -> None:
        self.connected = False
        await self.worked(self.source.close)

    async def status(self) -> dict[str, Any]:
        rms = 0.0 if self.calibration is None else round(self.calibration.rms_px, 3)
        calibrated = self.calibration is not None
        return {"connected": self.connected, "calibrated": calibrated, "rms": rms}

    async def look(self, action: str, goal: GoalContext) -> "View":
        try:
            shot = await self.worked(self.source.take)
        except ActionFailed:
            self.connected = False
            raise
        self.connected = True
        return await self.worked(self._view, shot)

    def keep(self, fit: "Calibration", goal: GoalContext) -> None:
        text = json.dumps({"camera": str(self.file), "calibration": fit.to_dict()})
        write_whole(self.place.folder / KEPT, text.encode())

    def _kept(self) -> "Calibration | None":
        """The stored position, unless it was for another lens or cannot be read."""
        from .vision.pose import Calibration

        try:
            kept = json.loads((self.place.folder / KEPT).read_text(encoding="utf-8"))
            known = kept["camera"] == str(self.file)
            return Calibration.from_dict(kept["calibration"]) if known else None
        except (OSError, ValueError, KeyError, TypeError):
            return None

    def _view(self, shot: Shot) -> "View":
        from .vision.camera import CameraFault, of_size
        from .vision.view import DepthView, StereoView, View

        rows, columns = shot.picture.shape[:2]
        left, right = shot.picture, shot.right
        if right is None and self._holds_both(columns, rows):
            left, right = left[:, : columns // 2], left[:, columns // 2 :]
        try:
            camera = of_size(self.cameras, left.shape[1], rows, self.file)
        except CameraFault as fault:
            raise ActionFailed("CameraLost", str(fault)) from fault
        if right is not None:
            if camera.right is None:
                raise ActionFailed(
                    "CameraLost", f"{self.file} describes one eye, but there are two pictures"
                )
            return StereoView.of(left, right, camera, self.x_runs)
        if shot.depth is not None:
            return DepthView(left, shot.depth, camera.left, self.x_runs)
        return View(left, camera.left, self.x_runs)

    def _holds_both(self, columns: int, rows: int) -> bool:
        pairs = (camera.size for camera in self.cameras if camera.right is not None)
        return (columns // 2, rows) in pairs


def _source(config: dict[str, Any]) -> CameraFolder | CameraVideo:
    """Raises ValueError if the configuration names neither, or both."""
    if unknown := sorted(set(config) - set(OPTIONS)):
        raise ValueError(
            f"config has no key {', '.join(unknown)}; its keys are: {', '.join(OPTIONS)}"
        )
    if "camera" not in config:
        raise ValueError("config needs `camera`: the file that labrun calibrate-camera wrote")
    if ("device" in config) == ("folder" in config):
        raise ValueError("config needs a source of pictures: either `device` or `folder`")
    if "folder" in config:
        unit = config.get("depth_unit")
        return CameraFolder(
            Path(str(config["folder"])), None if unit is None else _above_zero(unit)
        )
    size = config.get("size")
    if size is not None and not (isinstance(size, list) and len(size) == 2):
        raise ValueError(f"size is {size!r}; write [width, height] in pixels")
    device = config["device"]
    number = int(device) if str(device).isdecimal() else str(device)
    return CameraVideo(number, None if size is None else (int(size[0]), int(size[1])))


def _above_zero(value: Any) -> float:
    number = float(value)
    if not 0 < number < 1e6:
        raise ValueError(f"depth_unit is {value!r}; it must be a number of mm above 0")
    return number
