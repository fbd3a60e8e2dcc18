"""Depth of a whole picture from the disparity of two eyes, and the depth of a single thing."""

from typing import TYPE_CHECKING

from ...driver import ActionFailed
from .rig import Rig

if TYPE_CHECKING:
    import numpy as np

NEAREST_MM, FARTHEST_MM = 380.0, 2000.0
WINDOW = 5
LEAST_SEEN = 0.2  # of the picture; with less, the eyes have nothing in common
MOST_SHIFTS = 512  # pixels to search along a row
HALF = 6  # pixels to either side of the requested one
LEAST_KNOWN = 0.25  # of the pixels around it
WILD = 6.0  # times as far from the median as half of the pixels: not part of the slope


def depth_map(left: "np.ndarray", right: "np.ndarray", rig: Rig) -> "np.ndarray":
    """Depth in mm for every pixel of the left picture, NaN where unknown; raises ActionFailed.

    The pictures are rectified and grey. OpenCV's StereoSGBM, after Hirschmueller (2008),
    doi:10.1109/TPAMI.2007.1166.
    """
    import cv2
    import numpy as np

    shifts = min(16 * int(np.ceil(rig.reach_mm / NEAREST_MM / 16)), MOST_SHIFTS)
    search = cv2.StereoSGBM.create(
        minDisparity=0,
        numDisparities=shifts,
        blockSize=WINDOW,
        P1=8 * WINDOW**2,
        P2=32 * WINDOW**2,
        disp12MaxDiff=1,
        uniquenessRatio=8,
        speckleWindowSize=200,
        speckleRange=2,
    )
    shift = search.compute(left, right).astype(np.float32) / 16
    known = shift > rig.reach_mm / FARTHEST_MM
    depth = np.where(known, rig.reach_mm / np.where(known, shift, 1), np.nan)
    seen = float(np.isfinite(depth).mean())
    if seen < LEAST_SEEN:
        raise ActionFailed("NoDepth", f"the two eyes agree on only {seen:.0%} of the picture")
    return depth.astype(np.float32)


def depth_around(depth: "np.ndarray", u: float, v: float) -> tuple[float, float]:
    """Median and spread of the depth around a pixel, mm; raises ActionFailed.

    The median, since a single pixel may be far off; the spread is the standard deviation of one
    pixel about the plane that fits them best, since a bench seen at an angle has a slope. Where one side of
    the pixel is a hole, as beside things that one of two eyes cannot see past, the other side's median is
    brought to the pixel along that slope.
    """
    import numpy as np

    row, column = round(v), round(u)
    height, width = depth.shape
    # As far to one side as to the other, or the slope of the bench would shift the median.
    half = min(HALF, row, column, height - 1 - row, width - 1 - column)
    window = depth[row - half : row + half + 1, column - half : column + half + 1]
    known = np.isfinite(window)
    if known.mean() < LEAST_KNOWN:
        raise ActionFailed(
            "NoDepth",
            f"only {known.mean():.0%} of the depth around pixel {u:g}, {v:g} is known: choose a place "
            "with more texture, or give the height",
        )
    middle = float(np.median(window[known]))
    far = np.abs(window - middle)
    near = known & (far <= WILD * np.median(far[known]))
    rows, columns = np.nonzero(near)
    slant = np.stack([rows, columns, np.ones(len(rows))], axis=1)
    values = window[near].astype(float)
    slope = np.linalg.lstsq(slant, values, rcond=None)[0]
    off = np.abs(values - slant @ slope)
    aside = np.array([half, half, 1.0]) - slant.mean(axis=0)
    return middle + float(aside @ slope), float(1.4826 * np.median(off))
