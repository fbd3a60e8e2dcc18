"""A folder as a camera: another program writes pictures into it, and the newest is what it sees.

`NAME.png` alone is a picture, or both eyes side by side; `NAME_depth.png` (.npy, .tif) beside it is
its depth map; `NAME_left.png` and `NAME_right.png` are two eyes. The writing program must write the
depth map or right picture first: a look starts from the newest picture that is neither.
"""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from ..driver import ActionFailed
from .vision.pictures import DEPTHS, PICTURES, PictureFault, read_depth, read_picture

if TYPE_CHECKING:
    import numpy as np

    from .vision.intrinsics import Intrinsics

PARTNERS = ("_depth", "_right")
TRIES, WAIT_S = 5, 0.2  # for a picture that is still being written


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """What a source of pictures delivers at a time: a picture, and what came with it.

    `eye` is the lens, where the camera itself knows it; `reach_mm` the distance of a thing that its two
    eyes for depth see one pixel apart.
    """

    picture: "np.ndarray"
    depth: "np.ndarray | None" = None
    right: "np.ndarray | None" = None
    eye: "Intrinsics | None" = None
    reach_mm: float | None = None


class CameraFolder:
    """Reads a folder; `depth_unit_mm` is one step of its depth maps, if not 0.1 mm."""

    def __init__(self, folder: Path, depth_unit_mm: float | None = None) -> None:
        self.folder = folder
        self.depth_unit_mm = depth_unit_mm

    def open(self) -> None:
        """Raise OSError if there is no such folder."""
        if not self.folder.is_dir():
            what = "not a folder" if self.folder.exists() else "missing"
            raise OSError(f"the picture folder {self.folder.absolute()} is {what}")

    def close(self) -> None:
        """Nothing to release."""

    def take(self) -> Shot:
        """The newest picture and its partner; raises ActionFailed."""
        fault: PictureFault | None = None
        for attempt in range(TRIES):
            if attempt:
                time.sleep(WAIT_S)
            try:
                return self._read(self._newest())
            except PictureFault as found:
                fault = found
        raise ActionFailed("CameraLost", str(fault))

    def _newest(self) -> Path:
        try:
            found = [
                (path.stat().st_mtime_ns, path.name)
                for path in self.folder.iterdir()
                if path.suffix.lower() in PICTURES and not path.stem.endswith(PARTNERS)
            ]
        except OSError as fault:
            raise ActionFailed(
                "CameraLost", f"the folder {self.folder} cannot be read: {fault.strerror}"
            ) from fault
        if not found:
            raise ActionFailed("CameraLost", f"there is no picture in the folder {self.folder}")
        return self.folder / max(found)[1]

    def _read(self, path: Path) -> Shot:
        picture = read_picture(path)
        stem = path.stem.removesuffix("_left")
        if stem != path.stem:
            right = self._partner(stem + "_right", PICTURES)
            if right is None:
                raise PictureFault(f"{path} is a left-eye picture without {stem}_right beside it")
            return Shot(picture, right=read_picture(right))
        depth = self._partner(stem + "_depth", DEPTHS)
        return Shot(picture, None if depth is None else read_depth(depth, self.depth_unit_mm))

    def _partner(self, stem: str, suffixes: tuple[str, ...]) -> Path | None:
        places = (self.folder / f"{stem}{suffix}" for suffix in suffixes)
        return next((place for place in places if place.is_file()), None)
