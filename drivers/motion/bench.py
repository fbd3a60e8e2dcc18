"""Bench and machine coordinates: where zero is, which axis is which, how far each one goes.

`origin` is the machine position of the bench's zero, per bench axis; by default the corner at the
minus end of the machine's own ranges.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ...schemas.contracts import shipped_contracts
from ..driver import ActionFailed, Place
from .gantry import AXES
from .keep_out import Box, read_boxes

LETTERS = AXES.upper()
Point = tuple[float, ...]
"""Three to six numbers: x y z a b c."""

ROUNDING_MM = 0.006  # a step and the report's last digit: a position on the edge is inside

Limits = Mapping[str, tuple[float | None, float | None]]


@dataclass(frozen=True, slots=True)
class Bench:
    """`index[i]` and `sign[i]` say which machine axis is bench axis i, and in which direction.

    `low` and `high` are the range of the bench's axes, in mm on the bench.
    """

    index: tuple[int, ...]
    sign: tuple[int, ...]
    origin: Point
    low: Point
    high: Point
    boxes: tuple[Box, ...] = ()

    @property
    def axes(self) -> str:
        """The axes that this bench has: `xyz`, `xyza`."""
        return AXES[: len(self.index)]

    def to_bench(self, machine: Point) -> Point:
        """The bench position of a machine position."""
        return tuple(
            sign * (machine[index] - origin)
            for index, sign, origin in zip(self.index, self.sign, self.origin, strict=True)
        )

    def check_axes(self, named: Iterable[str], device: str) -> None:
        """Raise NotAvailable for an axis that this machine lacks."""
        for axis in named:
            if axis not in self.axes:
                there = ", ".join(self.axes)
                words = f"{device} was not moved: it has no axis {axis}; it has {there}"
                raise ActionFailed("NotAvailable", words, "no")

    def to_machine(self, axis: int, value: float) -> tuple[int, float]:
        """The machine axis and its position for one bench coordinate."""
        return self.index[axis], self.origin[axis] + self.sign[axis] * value

    def check_range(self, wanted: dict[str, float], device: str) -> None:
        """Raise SoftLimit for the first coordinate that is out of range, or not a number."""
        for axis, value in wanted.items():
            low, high = self.low[AXES.index(axis)], self.high[AXES.index(axis)]
            if not low - ROUNDING_MM <= value <= high + ROUNDING_MM:  # neither is true of NaN
                raise ActionFailed(
                    "SoftLimit",
                    f"{device} was not moved: {axis} {value:g} {unit(axis)} is outside "
                    f"{low:g} to {high:g} {unit(axis)} (the work area of this bench)",
                )

    def check_path(self, start: Point, end: Point, device: str) -> None:
        """Raise SoftLimit if the straight path goes through a keep-out box."""
        a, b = _three(start), _three(end)
        for box in self.boxes:
            if box.holds(a) and not box.holds(b):
                continue  # the way out is open
            if box.meets(a, b):
                raise ActionFailed(
                    "SoftLimit",
                    f"{device} was not moved: the path from {place_words(start)} to {place_words(end)} goes "
                    f"through the keep-out box {box.ranges()}; go around it",
                )

    def reach(self, start: Point, way: Mapping[int, int]) -> float:
        """How far these axes may go from here, each in its direction (1 or -1), all at once."""
        far = min(
            self.high[axis] - start[axis] if sign > 0 else start[axis] - self.low[axis]
            for axis, sign in way.items()
        )
        here, (x, y, z) = _three(start), (float(way.get(axis, 0)) for axis in range(3))
        stops = [
            stop
            for box in self.boxes
            if not box.holds(here) and (stop := box.entered(here, (x, y, z), far)) is not None
        ]
        return min([far, *stops])


def read_bench(
    config: dict[str, Any], limits: Limits, ranges: Sequence[tuple[float, float]]
) -> Bench:
    """Built from a lab's config, its limits and the contract's, and the machine's own ranges."""
    names = AXES[: len(ranges)]
    index, sign = zip(*(_axis(config, name, names) for name in names), strict=True)
    origins, lows, highs = [], [], []
    for i, name in enumerate(names):
        minus, plus = ranges[index[i]]
        given = (config.get("origin") or {}).get(name)
        origin = (minus if sign[i] > 0 else plus) if given is None else float(given)
        low, high = _both(limits.get(name), sorted(sign[i] * (m - origin) for m in (minus, plus)))
        origins.append(origin)
        lows.append(low)
        highs.append(high)
    return Bench(index, sign, tuple(origins), tuple(lows), tuple(highs), read_boxes(config))


def bench_from_here(config: dict[str, Any], limits: Limits, machine: Point) -> Bench:
    """For a machine without switches, whose carriage was put at `home_here` by hand."""
    names = AXES[: len(machine)]
    index, sign = zip(*(_axis(config, name, names) for name in names), strict=True)
    here = [float((config.get("home_here") or {}).get(name, 0.0)) for name in names]
    origin = tuple(machine[index[i]] - sign[i] * here[i] for i in range(len(names)))
    lows, highs = zip(
        *(_both(limits.get(name), [float("-inf"), float("inf")]) for name in names), strict=True
    )
    return Bench(index, sign, origin, lows, highs, read_boxes(config))


def _both(
    limits: tuple[float | None, float | None] | None, ends: list[float]
) -> tuple[float, float]:
    low, high = limits or (None, None)
    return (
        ends[0] if low is None else max(low, ends[0]),
        ends[1] if high is None else min(high, ends[1]),
    )


def whole_limits(place: Place) -> Limits:
    """The lab's axis limits, narrowed to the contract's own where it has any (gantry@1 does)."""
    contract = place.contract or shipped_contracts()["gantry@1"]
    schemas = contract.actions["move_to"].param_schemas()
    return {
        axis: _both(
            place.limits.get(axis),
            [schema.get("minimum", float("-inf")), schema.get("maximum", float("inf"))],
        )
        for axis in AXES
        if (schema := schemas.get(axis)) is not None
    }


def _axis(config: dict[str, Any], name: str, names: str) -> tuple[int, int]:
    """`Y` or `-Y` as (1, 1) or (1, -1)."""
    written = str((config.get("axes") or {}).get(name, name)).lower()
    letter = written.lstrip("-")
    if letter not in names:
        raise OSError(f"axes: {name} is {letter.upper()}, but the machine has {names.upper()} only")
    return AXES.index(letter), -1 if written.startswith("-") else 1


def _three(place: Point) -> tuple[float, float, float]:
    x, y, z, *_ = place
    return x, y, z


def unit(axis: str) -> str:
    """What an axis counts in."""
    return "mm" if axis in "xyz" else "deg"


def place_words(place: Point) -> str:
    """A position for people to read."""
    turned = "".join(f" {a} {v:.3f} deg" for a, v in zip(AXES[3:], place[3:], strict=False))
    return f"x {place[0]:.3f} y {place[1]:.3f} z {place[2]:.3f} mm{turned}"
