"""Boxes on the bench that the tool must not enter: a clamp, a camera leg, the sample holder."""

from dataclasses import dataclass
from typing import Any

from ..driver import Misfit, check_keys

Point = tuple[float, float, float]

INFINITE = float("inf")
TOUCH_MM = 0.01  # a position on a box's face has not entered it


@dataclass(frozen=True, slots=True)
class Box:
    """Ranges on the bench in mm, as written; an axis that is left out is blocked at any value."""

    name: str
    low: Point
    high: Point

    @property
    def inside(self) -> tuple[Point, Point]:
        """Low and high of the blocked range: a little less, so that a face may be touched."""
        (x0, y0, z0), (x1, y1, z1) = self.low, self.high
        return (
            (x0 + TOUCH_MM, y0 + TOUCH_MM, z0 + TOUCH_MM),
            (x1 - TOUCH_MM, y1 - TOUCH_MM, z1 - TOUCH_MM),
        )

    def holds(self, place: Point) -> bool:
        """Whether a position is inside."""
        low, high = self.inside
        return all(a < p < b for a, p, b in zip(low, place, high, strict=True))

    def meets(self, start: Point, end: Point) -> bool:
        """Whether the straight path between two positions goes through."""
        x, y, z = (b - a for a, b in zip(start, end, strict=True))
        return self.entered(start, (x, y, z), 1.0) is not None

    def entered(self, start: Point, way: Point, far: float) -> float | None:
        """How many times `way` lies before this box; None if it is not met within `far` (the slab method)."""
        enter, leave = 0.0, far
        for at, step, low, high in zip(start, way, *self.inside, strict=True):
            if step == 0:
                if not low < at < high:
                    return None
                continue
            near, beyond = sorted(((low - at) / step, (high - at) / step))
            enter, leave = max(enter, near), min(leave, beyond)
        return enter if enter < leave else None

    def ranges(self) -> str:
        """Its name and ranges."""
        ranges = [
            f"{axis} {low:g} to {high:g}"
            for axis, low, high in zip("xyz", self.low, self.high, strict=True)
            if (low, high) != (-INFINITE, INFINITE)
        ]
        return f"`{self.name}` ({', '.join(ranges)} mm)"


def read_boxes(config: dict[str, Any]) -> tuple[Box, ...]:
    """The boxes of `keep_out: [{name: clamp, x: [10, 20], y: [0, 40], z: [0, 30]}]`."""
    return tuple(_box(number, box) for number, box in enumerate(config.get("keep_out") or [], 1))


def _box(number: int, written: dict[str, Any]) -> Box:
    name = str(written.get("name", number))
    at = ("keep_out", number - 1)
    check_keys(("name", *"xyz"), written, f"keep_out box {name}", at)
    if not set(written) & set("xyz"):
        raise Misfit(f"keep_out box {name} has no range; write x, y or z as [from, to] in mm", at)
    ranges = [_range(name, (*at, axis), written.get(axis)) for axis in "xyz"]
    (x0, x1), (y0, y1), (z0, z1) = ranges
    return Box(name, (x0, y0, z0), (x1, y1, z1))


def _range(name: str, at: tuple[str | int, ...], written: Any) -> tuple[float, float]:
    if written is None:
        return -INFINITE, INFINITE
    try:
        low, high = (float(end) for end in written)
    except (TypeError, ValueError):
        low = high = 0.0
    if not low < high:
        raise Misfit(f"keep_out box {name}: {at[-1]} is {written!r}, not [from, to] in mm", at)
    return low, high
