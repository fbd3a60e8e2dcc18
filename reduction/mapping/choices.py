"""The options of a map, and the elements that follow for the given points."""

from dataclasses import dataclass, field

import numpy as np

from ..figures.paper import Format
from ..lines.symbols import BY_NUMBER, SYMBOLS
from ..maps.classes.classify import usual_features
from ..maps.points.points import Points
from ..maps.points.scales import Scale

LEAST_PART = 0.05  # of the points at which an element must be seen to be shown by default
MOST_ELEMENTS = 12  # shown by default
NOT_OF_THE_SAMPLE = frozenset({"Ar", "He", "N"})  # the chamber's gas, and air


@dataclass(frozen=True, slots=True)
class MapChoices:
    """elements: None for those seen at enough points; features: None for `usual_features`;
    n_classes: None for silhouette. correct_drift: concentrations by the run's check standards."""

    elements: tuple[str, ...] | None = None
    features: tuple[str, ...] | None = None
    n_classes: int | None = None
    scale: Scale = "min-max"
    format: Format = "png"
    correct_drift: bool = False


@dataclass(frozen=True, slots=True)
class Shown:
    """Elements to show, and sentences on those that are not."""

    elements: list[str]
    notes: list[str] = field(default_factory=list)


def elements_to_show(points: Points, choices: MapChoices) -> Shown:
    """The requested elements that are present; else those seen at enough of the points.

    An element is seen if the reduction detected it, or without tables if its area is above 0. The
    elements used for classes are always included.

    Raises ValueError, with a sentence, if a symbol is not an element or nothing is left.
    """
    if (asked := choices.elements) is None:
        return _seen(points, choices.features or usual_features(points))
    unknown = [name for name in asked if name not in SYMBOLS]
    if unknown:
        raise ValueError(f"{unknown[0]!r} is not an element symbol")
    there = [name for name in dict.fromkeys(asked) if _known(points, name)]
    missing = [name for name in asked if name not in there]
    if not there:
        have = ", ".join(e for e in points.area if _known(points, e)) or "none"
        raise ValueError(f"there is no area of {' or '.join(missing)} here, only of {have}")
    notes = [f"there is no area of {', '.join(missing)} here"] if missing else []
    return Shown(there, notes)


def _known(points: Points, element: str) -> bool:
    return element in points.area and bool(np.isfinite(points.area[element]).any())


def _seen(points: Points, features: tuple[str, ...]) -> Shown:
    part = {e: _part(points, e) for e in points.area if _known(points, e)}
    seen = [e for e in part if part[e] >= LEAST_PART and e not in NOT_OF_THE_SAMPLE]
    telling = [e for e in features if part.get(e, 0.0) > 0]
    if not seen and not telling:
        raise ValueError(
            "no element is seen at enough points to be mapped: name some with --elements"
        )
    order: list[str] = list(BY_NUMBER.split())
    often = sorted({*seen, *telling}, key=lambda e: (e not in telling, -part[e], order.index(e)))
    shown = sorted(often[:MOST_ELEMENTS], key=order.index)
    left = sorted(often[MOST_ELEMENTS:], key=order.index)
    notes = (
        [f"also seen, but drawn only on request (--elements): {', '.join(left)}"] if left else []
    )
    return Shown(shown, notes)


def _part(points: Points, element: str) -> float:
    """Fraction of the measured points at which an element is seen."""
    area = points.area[element]
    seen = area > 0
    if points.reduced is not None and points.reduced.elements is not None:
        table = points.reduced.elements
        sure = np.zeros(len(points.reduced.spectra), dtype=bool)
        sure[table.at[(table.element == element) & (table.status == "detected")]] = True
        seen &= (points.spectrum < 0) | sure[points.spectrum]
    return float(np.mean(seen[np.isfinite(area)]))
