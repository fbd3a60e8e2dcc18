"""Find the points inside an outline, such as a sample outline from a camera."""

from collections.abc import Mapping, Sequence
from typing import Any

from ...schemas.quantity import UnitError, is_quantity, magnitude_in
from .operators import OperatorFault, words

MOST_POINTS = 1_000_000
MOST_PAIRS = 2_000_000  # points times edges computed at once


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
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise OperatorFault(f"inside: {name} is {words(value)}, not a number")
    return float(value)


def _kept(
    points: list[tuple[float, float]], corners: list[tuple[float, float]], margin: float
) -> list[int]:
    """Indices of the points inside: a line to the right of each crosses an odd number of edges."""
    import numpy as np

    begin = np.array(corners)
    edge = np.roll(begin, -1, axis=0) - begin
    long = np.maximum((edge**2).sum(axis=1), 1e-300)
    close = 1e-9 * (1 + float(np.abs(begin).max()))
    kept: list[int] = []
    at_once = max(1, MOST_PAIRS // len(corners))
    for first in range(0, len(points), at_once):
        place = np.array(points[first : first + at_once])[:, None]
        to = place - begin
        crosses = (begin[:, 1] > place[..., 1]) != ((begin + edge)[:, 1] > place[..., 1])
        with np.errstate(divide="ignore", invalid="ignore"):
            at = begin[:, 0] + to[..., 1] * edge[:, 0] / edge[:, 1]
        within = (crosses & (place[..., 0] < at)).sum(axis=1) % 2 == 1
        share = np.clip((to * edge).sum(axis=-1) / long, 0, 1)
        away = np.sqrt(((to - share[..., None] * edge) ** 2).sum(axis=-1)).min(axis=1)
        good = (away >= margin - close) & within if margin > 0 else within | (away <= close)
        kept += (first + np.nonzero(good)[0]).tolist()
    return kept
