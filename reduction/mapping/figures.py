"""Draw all figures of a map, skipping those without data."""

from collections.abc import Iterator
from itertools import chain
from pathlib import Path

import numpy as np

from ..figures.class_map import class_map_figure
from ..figures.class_scatter import class_scatter_figure
from ..figures.lithium_ratio import lithium_ratio_figure
from ..figures.lithium_share import lithium_share_figure
from ..figures.paper import paper, save
from ..figures.series import Series
from ..figures.temperature_map import temperature_map_figure
from ..maps.classes.classify import Classes
from ..maps.classes.minerals import UNNAMED
from ..maps.points.lithium import lithium_ratios
from ..maps.points.points import Points
from ..maps.scattered import along_line, map_of
from ..spectrum.spectrum import BoolArray, FloatArray
from .choices import MapChoices
from .grades import SampleGrade, grade_figures
from .sample_figures import Drawn, sample_figures, samples_of
from .tables import BY_WT


def draw_figures(
    points: Points, elements: list[str], classes: Classes | None,
    composed: tuple[Points, Classes] | None, grades: list[SampleGrade], choices: MapChoices, folder: Path,
) -> list[Path]:  # fmt: skip
    """The figures written. Raises OSError if one cannot be written."""
    with paper():
        return [
            save(draw(), folder / f"{name}.{choices.format}")
            for name, draw in chain(
                _figures(points, elements, classes, choices),
                () if composed is None else _class_map(*composed, BY_WT),
                grade_figures(grades, points.unit),
            )
        ]


def _areas(points: Points) -> dict[str, BoolArray]:
    """The points of each sample that are not on one line."""
    return {
        sample: own
        for sample, own in samples_of(points).items()
        if np.sum(own) > 1 and along_line(points.x[own], points.y[own]) is None
    }


def _class_map(points: Points, classes: Classes, which: str = "") -> Iterator[Drawn]:
    if areas := _areas(points):
        label = np.where(points.measured, classes.label.astype(np.float64), np.nan)
        maps = _maps(points, label, areas)
        yield f"class_map{which}", lambda: class_map_figure(maps, classes, points.unit)


def _figures(points: Points, elements, classes, choices: MapChoices) -> Iterator[Drawn]:
    yield from sample_figures(points, elements, classes, choices)
    areas = _areas(points)
    if classes is not None:
        yield from _class_map(points, classes)
    if areas and np.isfinite(points.temperature_k).any():
        maps = _maps(points, points.temperature_k, areas)
        drawn = np.any(list(areas.values()), axis=0) & np.isfinite(points.temperature_k)
        error_k = points.temperature_error_k[drawn]
        yield "temperature_map", lambda: temperature_map_figure(maps, points.unit, error_k)
    if classes is not None:
        yield "classes", lambda: class_scatter_figure(points, classes)
    yield from _lithium(points, classes)


def _lithium(points: Points, classes: Classes | None) -> Iterator[Drawn]:
    if points.reduced is None:
        return
    labels = None if classes is None else classes.label.astype(np.float64)
    names = {} if classes is None else _names(classes)
    kelvin = Series(points.temperature_k, points.temperature_error_k)
    at, here = points.spectrum, points.spectrum >= 0
    found = lithium_ratios(points.reduced)
    ratio = Series(np.where(here, found.value[at], np.nan), np.where(here, found.error[at], np.nan))
    if np.isfinite(ratio.value * kelvin.value).any():
        yield "lithium_ratio", lambda: lithium_ratio_figure(kelvin, ratio, labels, names)
    told = points.reduced.li_cation_fraction, points.reduced.li_cation_fraction_error
    share, error = (np.where(here, values[at], np.nan) for values in told)
    if np.isfinite(share * kelvin.value).any():
        yield (
            "lithium_fraction",
            lambda: lithium_share_figure(kelvin, Series(share, error), labels, names=names),
        )


def _names(classes: Classes) -> dict[int, str]:
    """The likely mineral of each class that has one."""
    return {s.number - 1: s.likely for s in classes.summary if s.likely != UNNAMED}


def _maps(points: Points, values: FloatArray, areas: dict[str, BoolArray]):
    return {
        sample: map_of(points.x[own], points.y[own], values[own]) for sample, own in areas.items()
    }
