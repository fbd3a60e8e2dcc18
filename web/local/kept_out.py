"""Boxes that a machine keeps out of, from its entry in the lab: the page draws them."""

from math import isinf

from ...drivers.motion.keep_out import Box, read_boxes
from ...engine.lab.lab import LoadedLab
from ..models.devices import KeepOut


def kept_out(lab: LoadedLab | None, device: str) -> list[KeepOut]:
    """The boxes of a device's `keep_out`; none if they are invalid, which its driver reports."""
    own = lab.lab.devices.get(device) if lab is not None else None
    if own is None:
        return []
    try:
        boxes = read_boxes(own.config)
    except (ValueError, TypeError, AttributeError):
        return []
    return [_told(box) for box in boxes]


def _told(box: Box) -> KeepOut:
    x0, y0, z0 = (None if isinf(edge) else edge for edge in box.low)
    x1, y1, z1 = (None if isinf(edge) else edge for edge in box.high)
    return KeepOut(name=box.name, x0=x0, x1=x1, y0=y0, y1=y1, z0=z0, z1=z1)
