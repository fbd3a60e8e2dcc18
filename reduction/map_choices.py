"""What a person wants of a map, and which elements that means for the points at hand."""

from dataclasses import dataclass, field

import numpy as np

from .classes.classify import usual_features
from .figures.paper import Format
from .points.points import Points
from .scales import Scale
from .symbols import BY_NUMBER, SYMBOLS

LEAST_PART = 0.05  # of the points at which an element must be seen to be shown unasked
MOST_ELEMENTS = 12  # shown unasked
NOT_OF_THE_SAMPLE = frozenset({"Ar", "He", "N"})  # the chamber's gas, and air


@dataclass(frozen=True, slots=True)
class MapChoices:
    """elements: None for those that are seen in enough points; features: None for `usual_features`;
    n_classes: None for silhouette."""

    elements: tuple[str, ...] | None = None
    features: tuple[str, ...] | None = None
    n_classes: int | None = None
    scale: Scale = "min-max"
    format: Format = "png"


@dataclass(frozen=True, slots=True)
class Shown:
    """Elements to be shown, and sentences on those that are not."""

    elements: list[str]
    notes: list[str] = field(default_factory=list)


def elements_to_show(points: Points, choices: MapChoices) -> Shown:
    """The elements asked for, as far as they are there; else those seen in enough of the points.

    Seen is what the reduction calls detected, where its tables say; else an area above 0. Elements
    that tell classes apart are always among them.

    Raises ValueError, with a sentence, where a symbol is none or nothing is left.
    """
    if (asked := choices.elements) is None:
        return _seen(points, choices.features or usual_features(points))
    unknown = [name for name in asked if name not in SYMBOLS]
    if unknown:
        raise ValueError(f"{unknown[0]!r} is no symbol of an element")
    there = [name for name in dict.fromkeys(asked) if _known(points, name)]
    missing = [name for name in asked if name not in there]
    if not there:
        have = ", ".join(e for e in points.area if _known(points, e)) or "none"
        raise ValueError(
            f"there is no area of {' or '.join(missing)} here; there are those of {have}"
        )
    notes = [f"there is no area of {', '.join(missing)} here"] if missing else []
    return Shown(there, notes)


def _known(points: Points, element: str) -> bool:
    return element in points.area and bool(np.isfinite(points.area[element]).any())


def _seen(points: Points, features: tuple[str, ...]) -> Shown:
    part = {e: _part(points, e) for e in points.area if _known(points, e)}
    seen = [e for e in part if part[e] >= LEAST_PART and e not in NOT_OF_THE_SAMPLE]
    telling = [e for e in features if part.get(e, 0.0) > 0]
    if not seen and not telling:
        raise ValueError("no element is seen in enough points to be mapped: name some (--elements)")
    order: list[str] = list(BY_NUMBER.split())
    often = sorted({*seen, *telling}, key=lambda e: (e not in telling, -part[e], order.index(e)))
    shown = sorted(often[:MOST_ELEMENTS], key=order.index)
    left = sorted(often[MOST_ELEMENTS:], key=order.index)
    notes = [f"also seen, and not drawn unless asked for: {', '.join(left)}"] if left else []
    return Shown(shown, notes)


def _part(points: Points, element: str) -> float:
    """Part of the measured points in which an element is seen."""
    area = points.area[element]
    seen = area > 0
    if points.reduced is not None and points.reduced.elements is not None:
        table = points.reduced.elements
        sure = np.zeros(len(points.reduced.spectra), dtype=bool)
        sure[table.at[(table.element == element) & (table.status == "detected")]] = True
        seen &= (points.spectrum < 0) | sure[points.spectrum]
    return float(np.mean(seen[np.isfinite(area)]))
