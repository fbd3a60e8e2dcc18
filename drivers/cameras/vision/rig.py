"""Two eyes side by side with rectified pictures, and how to rectify those of real eyes."""

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from .camera import Camera
from .intrinsics import Intrinsics

if TYPE_CHECKING:
    import numpy as np

    Maps = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, slots=True, eq=False)
class Rig:
    """Both eyes are `eye`; the right one is `baseline_mm` from the left one along the rows."""

    eye: Intrinsics
    baseline_mm: float

    @property
    def reach_mm(self) -> float:
        """Depth times disparity: the distance of a thing that the eyes see one pixel apart."""
        return self.eye.focal_px * self.baseline_mm


@lru_cache(maxsize=4)
def rectification(camera: Camera) -> tuple[Rig, "Maps", "Maps"]:
    """The rig for a camera of two eyes, and the maps that rectify each eye's pictures.

    Raises ValueError for a camera of one eye.
    """
    import cv2
    import numpy as np

    if camera.right is None or camera.turn is None or camera.shift_mm is None:
        raise ValueError("a camera of one eye cannot be rectified")
    left, right = camera.left, camera.right
    size = left.width, left.height
    turned = cv2.stereoRectify(
        left.matrix, left.distortion, right.matrix, right.distortion, size,
        camera.turn, camera.shift_mm.reshape(3, 1), flags=cv2.CALIB_ZERO_DISPARITY, alpha=0,
    )  # fmt: skip
    maps = [
        cv2.initUndistortRectifyMap(e.matrix, e.distortion, turn, to, size, cv2.CV_32FC1)
        for e, turn, to in zip((left, right), turned[:2], turned[2:4], strict=True)
    ]
    eye = Intrinsics(*size, np.ascontiguousarray(turned[2][:, :3]), np.zeros(5))
    baseline_mm = float(np.linalg.norm(camera.shift_mm))
    return Rig(eye, baseline_mm), maps[0], maps[1]


def rectified(picture: "np.ndarray", maps: "Maps") -> "np.ndarray":
    """A picture as the rig's eye would have taken it."""
    import cv2

    return cv2.remap(picture, maps[0], maps[1], cv2.INTER_LINEAR)
