"""Draw all figures of a map, each where there is something to draw."""

import re
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np

from .classes.classify import Classes
from .figures.class_map import class_map_figure
from .figures.class_scatter import class_scatter_figure
from .figures.element_maps import element_maps_figure
from .figures.line_scan import line_scan_figure
from .figures.lithium_ratio import lithium_ratio_figure
from .figures.lithium_share import lithium_share_figure
from .figures.paper import paper, save, short
from .figures.series import Series
from .figures.temperature_map import temperature_map_figure
from .map_choices import MapChoices
from .points.lithium import lithium_ratios, lithium_shares
from .points.points import Points
from .scales import on_scale
from .scattered import along_line, map_of
from .spectrum import BoolArray, FloatArray

OWN_BARS = {"absolute": "area (counts nm)", "total": "part of the area of all peaks (%)"}
LINE_LABELS = {"min-max": "area, lowest (0) to highest (1)", **OWN_BARS}

Drawn = tuple[str, Callable]


def draw_figures(
    points: Points, elements: list[str], classes: Classes | None, choices: MapChoices, folder: Path
) -> list[Path]:
    """The figures that were written. Raises OSError where one cannot be."""
    with paper():
        return [
            save(draw(), folder / f"{name}.{choices.format}")
            for name, draw in _figures(points, elements, classes, choices)
        ]


def sample_figures(
    points: Points, elements: list[str], classes: Classes | None, choices: MapChoices,
    title: str = "",
) -> Iterator[Drawn]:  # fmt: skip
    """Of each sample its element maps, or the profile along its line; nothing of a single point."""
    for sample, own in _samples(points).items():
        way = along_line(points.x[own], points.y[own])
        name = _slug(sample)
        if way is not None:
            yield f"line_scan{name}", partial(_line, points, elements, classes, choices, own, way)
        elif np.sum(own) > 1:
            said = " ".join(filter(None, (title, sample)))
            yield f"element_maps{name}", partial(_elements, points, elements, choices, own, said)


def _samples(points: Points) -> dict[str, BoolArray]:
    placed = {s for s, here in zip(points.sample, points.placed, strict=True) if here}
    return {sample: points.of_sample(sample) for sample in sorted(placed)}


def _figures(points: Points, elements, classes, choices: MapChoices) -> Iterator[Drawn]:
    yield from sample_figures(points, elements, classes, choices)
    areas = {
        sample: own
        for sample, own in _samples(points).items()
        if np.sum(own) > 1 and along_line(points.x[own], points.y[own]) is None
    }
    if areas and classes is not None:
        label = np.where(points.measured, classes.label.astype(np.float64), np.nan)
        yield (
            "class_map",
            lambda: class_map_figure(_maps(points, label, areas), classes, points.unit),
        )
    if areas and np.isfinite(points.temperature_k).any():
        maps = _maps(points, points.temperature_k, areas)
        yield "temperature_map", lambda: temperature_map_figure(maps, points.unit)
    if classes is not None:
        yield "classes", lambda: class_scatter_figure(points, classes)
    yield from _lithium(points, classes)


def _lithium(points: Points, classes: Classes | None) -> Iterator[Drawn]:
    if points.reduced is None:
        return
    labels = None if classes is None else classes.label.astype(np.float64)
    kelvin = Series(points.temperature_k, points.temperature_error_k)
    at, here = points.spectrum, points.spectrum >= 0
    found = lithium_ratios(points.reduced)
    ratio = Series(np.where(here, found.value[at], np.nan), np.where(here, found.error[at], np.nan))
    if np.isfinite(ratio.value * kelvin.value).any():
        yield "lithium_ratio", lambda: lithium_ratio_figure(kelvin, ratio, labels)
        share = np.where(here, lithium_shares(points.reduced)[at], np.nan)
        yield (
            "lithium_fraction",
            lambda: lithium_share_figure(
                kelvin, Series(share, np.full(len(share), np.nan)), labels
            ),
        )


def _elements(points: Points, elements, choices: MapChoices, own: BoolArray, said: str):
    limits, below, maps = {}, {}, {}
    for element in elements:
        title = _title(points, element)
        value = on_scale(points, element, choices.scale)
        maps[title] = map_of(points.x[own], points.y[own], value[own])
        known = value[np.isfinite(value)]
        limits[title] = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
        area = points.area[element][np.isfinite(points.area[element])]
        if len(area):
            below[title] = f"{short(float(area.min()))} to {short(float(area.max()))}"
    return element_maps_figure(
        maps,
        said,
        points.unit,
        own_bars=OWN_BARS.get(choices.scale),
        limits=limits,
        below=below,
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


def _maps(points: Points, values: FloatArray, areas: dict[str, BoolArray]):
    return {
        sample: map_of(points.x[own], points.y[own], values[own]) for sample, own in areas.items()
    }


def _title(points: Points, element: str) -> str:
    line = points.line_nm.get(element)
    symbol = rf"$\bf{{{element}}}$"
    return f"{symbol} {line:.1f} nm" if line else symbol


def _slug(sample: str) -> str:
    """A sample's name as the end of a file name, '' for the only one."""
    slug = re.sub(r"[^0-9A-Za-z.-]+", "-", sample).strip("-.")
    return f"_{slug}" if slug else ""
