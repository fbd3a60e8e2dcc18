"""A depth camera over the bench: a stereo camera on USB, or a folder that another program fills.

Configuration: `camera` (the file of its lens or lenses: `labrun calibrate-camera`, OpenCV, or a
ZED's .conf), and either `device` (a number, /dev/video2, rtsp://..., a film) with `size` ([width,
height] to request), or `folder` with `depth_unit` (one step of its depth maps in mm, default 0.1).
`x_runs` is the direction of bench x in the picture: right (the default), up, left or down.
A picture twice as wide as one eye's holds both eyes side by side.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..driver import ActionFailed, Place
from .folder import CameraFolder, Shot
from .still_camera import StillCamera, above_zero, picture_size
from .video import CameraVideo

if TYPE_CHECKING:
    from .vision.camera import Camera
    from .vision.view import View

OPTIONS = ("camera", "device", "folder", "size", "depth_unit")


class StereoCamera(StillCamera):
    """Implements depth_camera@1, with a lens that a file describes."""

    def __init__(self, place: Place) -> None:
        super().__init__(place, _source(place.config), OPTIONS)
        self.file = Path(str(place.config["camera"]))
        self.cameras: tuple[Camera, ...] = ()

    @property
    def lens(self) -> str:
        return str(self.file)

    async def open(self) -> None:
        from .vision.camera_file import read_cameras

        try:
            self.cameras = await self.worked(read_cameras, self.file)
        except ValueError as fault:
            raise OSError(str(fault)) from fault
        await super().open()

    def view(self, shot: Shot) -> "View":
        from .vision.camera import CameraFault
        from .vision.view import view_of

        also = {"right": shot.right, "depth": shot.depth}
        try:
            return view_of(shot.picture, self.cameras, self.file, self.x_runs, **also)[0]
        except CameraFault as fault:
            raise ActionFailed("CameraLost", str(fault)) from fault


def _source(config: dict[str, Any]) -> CameraFolder | CameraVideo:
    """Raises ValueError if the configuration names neither, or both."""
    if "camera" not in config:
        raise ValueError("config needs `camera`: the file that labrun calibrate-camera wrote")
    if ("device" in config) == ("folder" in config):
        raise ValueError("config needs a source of pictures: either `device` or `folder`")
    if "folder" in config:
        unit = config.get("depth_unit")
        return CameraFolder(
            Path(str(config["folder"])), None if unit is None else above_zero(unit, "depth_unit")
        )
    device = config["device"]
    number = int(device) if str(device).isdecimal() else str(device)
    return CameraVideo(number, picture_size(config))
