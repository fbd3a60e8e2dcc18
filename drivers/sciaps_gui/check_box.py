"""Read a check box: ticked or not, decided on the pixels in which its two recordings differ."""

import cv2
import numpy as np

from .match import Hit, Picture, Template

DIFFERENT = 30
FEW = 8
DECISIVE = 0.7


def ticked(picture: Picture, hit: Hit, off: Template, on: Template) -> bool | None:
    """Whether the box at `hit` is ticked; None where it cannot be told."""
    height, width = off.picture.shape[:2]
    x, y, w, h = hit.box
    patch = _sized(picture[y : y + h, x : x + w], width, height)
    empty = _sized(off.picture, width, height)
    full = _sized(on.picture, width, height)
    where = np.abs(full - empty).max(axis=2) > DIFFERENT
    if where.sum() < FEW:
        return None
    from_empty = float(np.abs(patch - empty)[where].mean())
    from_full = float(np.abs(patch - full)[where].mean())
    nearer, farther = sorted((from_empty, from_full))
    if nearer > DECISIVE * farther:
        return None
    return from_full < from_empty


def _sized(picture: Picture, width: int, height: int) -> np.ndarray:
    return cv2.resize(picture, (width, height), interpolation=cv2.INTER_AREA).astype(np.float32)
