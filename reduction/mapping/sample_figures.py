"""Draw the maps of each sample, or the profile if its points are on one line."""

import re
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from ..figures.concentrations import ContentMaps, concentrations_figure
from ..figures.element_maps import element_maps_figure
from ..figures.line_scan import line_scan_figure
from ..figures.paper import short
from ..figures.robust import robust_limits
from ..lines.symbols import BY_NUMBER
from ..maps.classes.classify import Classes
from ..maps.points.contents import Contents
from ..maps.points.points import Points
from ..maps.points.scales import on_scale
from ..maps.scattered import along_line, map_of
from ..spectrum.spectrum import BoolArray, FloatArray
from .choices import MapChoices

OWN_BARS = {"absolute": "area (counts nm)", "total": "part of the area of all peaks (%)"}
LINE_LABELS = {"min-max": "area, lowest (0) to highest (1)", **OWN_BARS}

Drawn = tuple[str, Callable]


def sample_figures(
    points: Points, elements: list[str], classes: Classes | None, choices: MapChoices,
    title: str = "",
) -> Iterator[Drawn]:  # fmt: skip
    """The element maps of each sample, or the profile along its line, and the same in wt % where a
    calibration was used; nothing for a single point."""
    calibrated = concentrations_shown(points, choices)
    for sample, own in samples_of(points).items():
        way = along_line(points.x[own], points.y[own])
        name = slug(sample)
        area = way is None and np.sum(own) > 1
        said = " ".join(filter(None, (title, sample)))
        if way is not None and elements:
            yield f"line_scan{name}", partial(_line, points, elements, classes, choices, own, way)
        elif area and elements:
            yield f"element_maps{name}", partial(_elements, points, elements, choices, own, said)
        if way is not None and calibrated:
            yield f"concentrations{name}", partial(_line_of, points, calibrated, own, way)
        elif area and calibrated:
            yield f"concentrations{name}", partial(_concentrations, points, calibrated, own, said)


def concentrations_shown(points: Points, choices: MapChoices) -> list[str]:
    """The calibrated elements that are shown: those asked for, else all that were measured."""
    known = {element for element, one in points.contents.items() if one.known.any()}
    there = [element for element in BY_NUMBER.split() if element in known]
    return [e for e in there if choices.elements is None or e in choices.elements]


def samples_of(points: Points) -> dict[str, BoolArray]:
    placed = {s for s, here in zip(points.sample, points.placed, strict=True) if here}
    return {sample: points.of_sample(sample) for sample in sorted(placed)}


def _elements(points: Points, elements, choices: MapChoices, own: BoolArray, said: str):
    limits, below, maps = {}, {}, {}
    for element in elements:
        title = _title(points, element)
        value = on_scale(points, element, choices.scale)
        maps[title] = map_of(points.x[own], points.y[own], value[own])
        limits[title] = robust_limits(value)
        if np.isfinite(points.area[element]).any():
            area = robust_limits(points.area[element])
            below[title] = f"{short(area.lowest)} to {short(area.highest)}"
    return element_maps_figure(
        maps,
        said,
        points.unit,
        own_bars=OWN_BARS.get(choices.scale),
        limits=limits,
        below=below,
        below_in="counts nm" if below else "",
    )


def _line(points: Points, elements, classes, choices: MapChoices, own: BoolArray, way: FloatArray):
    values = {
        _title(points, e): on_scale(points, e, choices.scale)[own] for e in elements
    }  # fmt: skip
    errors = None
    if choices.scale == "absolute":
        errors = {_title(points, e): points.area_error[e][own] for e in elements}
    label = None if classes is None else classes.label[own].astype(np.float64)
    return line_scan_figure(way, values, points.unit, errors, label, LINE_LABELS[choices.scale])


def _concentrations(points: Points, elements: list[str], own: BoolArray, said: str):
    def drawn(values: FloatArray):
        return map_of(points.x[own], points.y[own], values[own])

    maps = {}
    for element in elements:
        one = points.contents[element]
        maps[element] = ContentMaps(
            drawn(np.where(one.covered, one.value, np.nan)), drawn(np.where(one.covered, one.error, np.nan)),
            drawn(np.where(one.below & ~one.above, 1.0, np.nan)), drawn(np.where(one.above, 1.0, np.nan)),
        )  # fmt: skip
    return concentrations_figure(maps, said, points.unit)


def _line_of(points: Points, elements: list[str], own: BoolArray, way: FloatArray):
    values, errors, least, most = {}, {}, {}, {}
    for element in elements:
        one: Contents = points.contents[element]
        name = rf"$\bf{{{element}}}$"
        values[name] = np.where(one.covered, one.value, np.nan)[own]
        errors[name] = one.error[own]
        least[name] = np.where(one.above, one.low, np.nan)[own]
        most[name] = np.where(one.below & ~one.above, one.high, np.nan)[own]
    return line_scan_figure(
        way,
        values,
        points.unit,
        errors,
        None,
        "wt %;  \u25bd at most,  \u25b3 at least",
        least,
        most,
    )


def _title(points: Points, element: str) -> str:
    line = points.line_nm.get(element)
    symbol = rf"$\bf{{{element}}}$"
    return f"{symbol} {line:.1f} nm" if line else symbol


def slug(sample: str) -> str:
    """A sample's name as a file name suffix, '' for the only one."""
    slug = re.sub(r"[^0-9A-Za-z.-]+", "-", sample).strip("-.")
    return f"_{slug}" if slug else ""
