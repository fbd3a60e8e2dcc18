"""Read a check box: ticked or not, from the area where its two recordings differ.

The square is found again within a few pixels (at another size letters are spaced differently, and it is
not just where it was), then the mean colour of what the tick fills says how much of it is there:
a mean minds neither the tick's exact shape nor its thickness.
"""

import numpy as np

from ...system.start import later
from .match import Hit, Picture, Template

with later("cv2"):
    import cv2

DIFFERENT = 30
FEW = 8
TICKED, EMPTY = 0.6, 0.4
BORDER = 4
REACH = 5
"""Pixels of the recording by which the square may be off."""


def ticked(picture: Picture, hit: Hit, off: Template, on: Template) -> bool | None:
    """Whether the box at `hit` is ticked; None if that is unclear."""
    height, width = off.picture.shape[:2]
    x, y, w, h = hit.box
    pictures = off.picture, on.picture, picture[y : y + h, x : x + w]
    empty, full, seen = (_sized(p, width, height) for p in pictures)
    where = np.abs(full - empty).max(axis=2) > DIFFERENT
    if where.sum() < FEW:
        return None
    rows, columns = _span(where.any(axis=1)), _span(where.any(axis=0))
    down, across = _shift(seen, (empty + full) / 2, rows, columns)
    plain, ink = (p[rows, columns].mean(axis=(0, 1)) for p in (empty, full))
    found = seen[_moved(rows, down), _moved(columns, across)].mean(axis=(0, 1))
    part = float(np.dot(found - plain, ink - plain) / np.dot(ink - plain, ink - plain))
    return None if EMPTY < part < TICKED else part >= TICKED


def _shift(seen: np.ndarray, square: np.ndarray, rows: slice, columns: slice) -> tuple[int, int]:
    """How far down and across the square with its outline is from where it was recorded."""
    outline = square[_wider(rows, BORDER), _wider(columns, BORDER)]
    near = seen[_wider(rows, BORDER + REACH), _wider(columns, BORDER + REACH)]
    _, _, (across, down), _ = cv2.minMaxLoc(cv2.matchTemplate(near, outline, cv2.TM_SQDIFF))
    return down - REACH, across - REACH


def _sized(picture: Picture, width: int, height: int) -> np.ndarray:
    """At the recording's size, with its edge drawn out on all sides."""
    resized = cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA)
    edge = BORDER + REACH
    return np.pad(resized, ((edge, edge), (edge, edge), (0, 0)), mode="edge").astype(np.float32)


def _span(there: np.ndarray) -> slice:
    """From the first to the last; what is drawn out beyond the edge is not counted."""
    within = np.flatnonzero(there[BORDER + REACH : len(there) - BORDER - REACH]) + BORDER + REACH
    return slice(int(within[0]), int(within[-1]) + 1)


def _wider(part: slice, by: int) -> slice:
    return slice(part.start - by, part.stop + by)


def _moved(part: slice, by: int) -> slice:
    return slice(part.start + by, part.stop + by)
