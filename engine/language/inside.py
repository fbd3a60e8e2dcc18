"""Find the points inside an outline, such as a sample outline from a camera."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ...schemas.quantity import UnitError, is_number, is_quantity, magnitude_in
from .operators import OperatorFault, words

MOST_POINTS = 1_000_000
Edge = tuple[float, float, float, float]
"""Where it begins, x and y, and how far it runs from there."""


def inside(points: Any = None, outline: Any = None, margin: Any = 0) -> list[Any] | None:
    """The points within an outline, at least `margin` from its edge, in their order.

    `outline` is a list of its corners; points and corners have an x and a y. A point on the edge
    is inside. Null if the points or the outline are null.
    """
    if points is None or outline is None:
        return None
    for name, value in (("points", points), ("outline", outline)):
        if isinstance(value, str | Mapping) or not isinstance(value, Sequence):
            raise OperatorFault(f"inside: the {name} must be a list or a grid, not {words(value)}")
    if len(points) > MOST_POINTS:
        raise OperatorFault(f"inside: more than {MOST_POINTS:,} points")
    if len(outline) < 3:
        raise OperatorFault(
            f"inside: an outline needs three corners or more, this one has {len(outline)}"
        )
    unit = _unit(outline[0])
    corners = _plane("the outline", outline, unit)
    away = _number("margin", margin, unit)
    if away < 0:
        raise OperatorFault("inside: the margin must not be negative")
    kept = _kept(_plane("the points", points, unit), corners, away)
    return [points[index] for index in kept]


def _unit(corner: Any) -> str | None:
    x = corner.get("x") if isinstance(corner, Mapping) else None
    return str(x.units) if is_quantity(x) else None


def _plane(name: str, points: Sequence[Any], unit: str | None) -> list[tuple[float, float]]:
    found = []
    for point in points:
        if not isinstance(point, Mapping) or "x" not in point or "y" not in point:
            raise OperatorFault(f"inside: {name} must have an x and a y; {words(point)} does not")
        found.append((_number("x", point["x"], unit), _number("y", point["y"], unit)))
    return found


def _number(name: str, value: Any, unit: str | None) -> float:
    if is_quantity(value) != (unit is not None) and value != 0:
        raise OperatorFault(f"inside: {name} is {words(value)}; either all have units or none")
    if is_quantity(value):
        try:
            return float(magnitude_in(value, unit or ""))
        except UnitError as fault:
            raise OperatorFault(f"inside: {name}: {fault}") from fault
    if not is_number(value):
        raise OperatorFault(f"inside: {name} is {words(value)}, not a number")
    return float(value)


def _kept(
    points: list[tuple[float, float]], corners: list[tuple[float, float]], margin: float
) -> list[int]:
    """Indices of the points inside: a line to the right of each crosses an odd number of edges."""
    close = 1e-9 * (1 + max(abs(number) for corner in corners for number in corner))
    edges = [
        (x, y, to_x - x, to_y - y)
        for (x, y), (to_x, to_y) in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    beside: dict[float, list[Edge]] = {}  # points of a grid share their few y
    kept: list[int] = []
    for index, (x, y) in enumerate(points):
        near = beside.get(y)
        if near is None:
            near = beside[y] = [edge for edge in edges if _is_near(edge, y, margin + close)]
        within = sum(_is_crossed(edge, x, y) for edge in near) % 2 == 1
        away = min((_distance(edge, x, y) for edge in near), default=math.inf)
        if (within and away >= margin - close) if margin > 0 else (within or away <= close):
            kept.append(index)
    return kept


def _is_near(edge: Edge, y: float, reach: float) -> bool:
    """Whether an edge comes as near to a height: no other is crossed there, or within reach."""
    _, begin, _, rise = edge
    return min(begin, begin + rise) - reach <= y <= max(begin, begin + rise) + reach


def _is_crossed(edge: Edge, x: float, y: float) -> bool:
    """Whether a line from a point to the right crosses an edge."""
    at_x, at_y, run, rise = edge
    return (at_y > y) != (at_y + rise > y) and x < at_x + (y - at_y) * run / rise


def _distance(edge: Edge, x: float, y: float) -> float:
    at_x, at_y, run, rise = edge
    to_x, to_y = x - at_x, y - at_y
    share = (to_x * run + to_y * rise) / max(run * run + rise * rise, 1e-300)
    share = min(max(share, 0.0), 1.0)
    return math.hypot(to_x - share * run, to_y - share * rise)
