"""How far everything in the picture is, from what the two eyes see differently."""

from typing import TYPE_CHECKING

from ..driver import ActionFailed
from .rig import Rig

if TYPE_CHECKING:
    import numpy as np

NEAREST_MM, FARTHEST_MM = 380.0, 2000.0
WINDOW = 5
LEAST_SEEN = 0.2  # of the picture; with less, the eyes have nothing in common


def depth_map(left: "np.ndarray", right: "np.ndarray", rig: Rig) -> "np.ndarray":
    """Millimetres ahead for every pixel of the left picture, NaN where unknown; raises ActionFailed."""
    import cv2
    import numpy as np

    reach_mm = rig.focal_px * rig.baseline_mm
    search = cv2.StereoSGBM.create(
        minDisparity=0,
        numDisparities=16 * int(np.ceil(reach_mm / NEAREST_MM / 16)),
        blockSize=WINDOW,
        P1=8 * WINDOW**2,
        P2=32 * WINDOW**2,
        disp12MaxDiff=1,
        uniquenessRatio=8,
        speckleWindowSize=200,
        speckleRange=2,
    )
    shift = search.compute(left, right).astype(np.float32) / 16
    known = shift > reach_mm / FARTHEST_MM
    depth = np.where(known, reach_mm / np.where(known, shift, 1), np.nan)
    seen = float(np.isfinite(depth).mean())
    if seen < LEAST_SEEN:
        raise ActionFailed("NoDepth", f"the two eyes agree on only {seen:.0%} of the picture")
    return depth.astype(np.float32)


def depth_around(depth: "np.ndarray", u: float, v: float, half: int = 6) -> float:
    """The median depth around a pixel, since a single one may be far off; raises ActionFailed."""
    import numpy as np

    row, column = round(v), round(u)
    window = depth[max(0, row - half) : row + half + 1, max(0, column - half) : column + half + 1]
    known = window[np.isfinite(window)]
    if known.size < window.size / 4:
        raise ActionFailed("NoDepth", f"the two eyes do not agree around pixel {u:g}, {v:g}")
    return float(np.median(known))
