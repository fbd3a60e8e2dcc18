"""Devices that move in a plane: found by their contracts, with the area that they may reach."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf
from typing import Any

from ....schemas.contract import Action, Contract
from ....schemas.lab import Limit
from ....schemas.quantity import UnitError, is_number, magnitude_in, same_dimension
from ...lab.bind import BoundRole

AXES = ("x", "y")
CLOSE_MM = 1e-6


@dataclass(frozen=True, slots=True)
class Area:
    """A rectangle in mm; infinite where it is not limited."""

    x: tuple[float, float] = (-inf, inf)
    y: tuple[float, float] = (-inf, inf)

    def holds(self, x_mm: float, y_mm: float) -> bool:
        """True for a point inside or on the edge."""
        return all(
            low - CLOSE_MM <= value <= high + CLOSE_MM
            for (low, high), value in ((self.x, x_mm), (self.y, y_mm))
        )

    @property
    def bounded(self) -> bool:
        """True if all four edges are known."""
        return all(abs(edge) != inf for edge in (*self.x, *self.y))

    def within(self, other: "Area") -> "Area":
        """The part in both."""
        (ax, ay), (bx, by) = (self.x, self.y), (other.x, other.y)
        return Area((max(ax[0], bx[0]), min(ax[1], bx[1])), (max(ay[0], by[0]), min(ay[1], by[1])))

    def __str__(self) -> str:
        return f"x {_range(self.x)}, y {_range(self.y)}"


def _range(edges: tuple[float, float]) -> str:
    low, high = (("" if abs(edge) == inf else f"{edge:g}") for edge in edges)
    return f"{low}..{high} mm"


@dataclass(frozen=True, slots=True)
class Plane:
    """A device that moves in a plane: what its contract allows, and the lab's part of it."""

    device: str
    contract: str
    allowed: Area
    bench: Area

    @property
    def area(self) -> Area:
        """Where it may go here."""
        return self.allowed.within(self.bench)


def moves_in_plane(contract: Contract, action: str) -> bool:
    """True for an action that takes a device to an x and a y, both lengths."""
    found = contract.actions.get(action)
    if found is None or not _two_lengths(found.param_schemas()):
        return False
    # An x and a y may also be the position of something else; a device that moves declares that
    # danger, or reports its position in its status.
    return found.danger == "motion" or _two_lengths(contract.status.get("properties", {}))


def _two_lengths(schemas: Mapping[str, Any]) -> bool:
    units = [schemas.get(axis, {}).get("unit") for axis in AXES]
    return all(unit is not None and same_dimension(unit, "mm") for unit in units)


def plane_of(bound: BoundRole) -> Plane | None:
    """The plane that a device moves in, or None if it does not."""
    moving = [
        action for name, action in bound.contract.actions.items()
        if moves_in_plane(bound.contract, name)
    ]  # fmt: skip
    if not moving:
        return None
    allowed = Area()
    for action in moving:
        allowed = allowed.within(_area(action))
    bench = Area(*(_limit(bound.limits.get(axis), moving[0], axis) for axis in AXES))
    return Plane(bound.device, bound.contract.type, allowed, bench)


def _area(action: Action) -> Area:
    return Area(*(_edges(action.param_schemas()[axis]) for axis in AXES))


def _edges(schema: Mapping[str, Any]) -> tuple[float, float]:
    unit = schema["unit"]
    low = schema.get("minimum", schema.get("exclusiveMinimum"))
    high = schema.get("maximum", schema.get("exclusiveMaximum"))
    return _mm(low, unit, -inf), _mm(high, unit, inf)


def _limit(limit: Limit | None, action: Action, axis: str) -> tuple[float, float]:
    if limit is None:
        return -inf, inf
    unit = action.param_schemas()[axis]["unit"]
    return _mm(limit.minimum, unit, -inf), _mm(limit.maximum, unit, inf)


def _mm(edge: Any, unit: str, otherwise: float) -> float:
    return otherwise if edge is None else in_mm(edge, unit)


def in_mm(value: Any, unit: str) -> float:
    """A length in mm; a bare number is in `unit`. Raises UnitError for anything else."""
    number = magnitude_in(value, unit)
    if not is_number(number):
        raise UnitError(f"{number!r} is not a length")
    return float(magnitude_in(f"{number!r} {unit}", "mm")) if unit != "mm" else float(number)
