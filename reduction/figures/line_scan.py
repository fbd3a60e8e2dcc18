"""Areas along a line of points, one strip per element, with the classes below."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..spectrum.spectrum import FloatArray
from .paper import (
    COLOURS,
    INK,
    ONE_COLUMN_IN,
    QUIET,
    TWO_COLUMNS_IN,
    class_colour,
    place,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STRIP_IN, GAP_IN = 0.62, 0.07
LEFT_IN, BOTTOM_IN, TOP_IN, RIGHT_IN = 0.56, 0.36, 0.1, 0.12
CLASSES_IN = 0.12
LONG = 60  # points from which on a line takes both columns


def line_scan_figure(
    way: FloatArray,
    values: Mapping[str, FloatArray],
    unit: str = "mm",
    errors: Mapping[str, FloatArray] | None = None,
    labels: FloatArray | None = None,
    scale: str = "area (counts nm)",
    least: Mapping[str, FloatArray] | None = None,
    most: Mapping[str, FloatArray] | None = None,
    axis: str = "the line",
) -> Figure:
    """way: distance along the axis, shape (n,); values by title, shape (n,), NaN is a gap.

    errors: standard errors, NaN where unknown; labels: classes from 0, below 0 for none. least,
    most: where only a lower or an upper end is known, drawn as a triangle that points away from it.
    Raises ValueError without values.
    """
    if not values:
        raise ValueError("there is nothing to draw along the line")
    from matplotlib.figure import Figure

    strip = CLASSES_IN + GAP_IN if labels is not None else 0.0
    width = TWO_COLUMNS_IN if len(way) > LONG else ONE_COLUMN_IN
    height = BOTTOM_IN + TOP_IN + strip + len(values) * (STRIP_IN + GAP_IN) - GAP_IN
    figure = Figure(figsize=(width, height))
    across = width - LEFT_IN - RIGHT_IN
    order = np.argsort(way, kind="stable")
    pitch = float(np.median(np.diff(way[order]))) if len(way) > 1 else 1.0
    limits = float(way.min() - 0.5 * pitch), float(way.max() + 0.5 * pitch)
    axes = None
    for row, (name, value) in enumerate(values.items()):
        bottom = height - TOP_IN - (row + 1) * STRIP_IN - row * GAP_IN
        axes = place(figure, LEFT_IN, bottom, across, STRIP_IN)
        ends = [None if one is None else one[name][order] for one in (least, most)]
        told = None if errors is None else errors[name][order]
        _profile(axes, way[order], value[order], told, *ends)
        axes.set_xlim(*limits)
        axes.text(0.008, 0.93, name, transform=axes.transAxes, va="top", ha="left")
        last = row == len(values) - 1 and labels is None
        axes.tick_params(labelbottom=last)
    if labels is not None:
        axes = place(figure, LEFT_IN, BOTTOM_IN, across, CLASSES_IN)
        for at in np.flatnonzero(labels >= 0):
            axes.axvspan(way[at] - pitch / 2, way[at] + pitch / 2, color=class_colour(int(labels[at])),
                         linewidth=0)  # fmt: skip
        axes.set_xlim(*limits)
        axes.set_yticks([])
        axes.set_ylabel("class", rotation=0, ha="right", va="center")
    if axes is not None:
        axes.set_xlabel(f"distance along {axis} ({unit})")
    middle = (BOTTOM_IN + strip + height - TOP_IN) / 2 / height
    figure.text(0.1 / width, middle, scale, rotation=90, va="center", ha="center")
    return figure


def _profile(
    axes, way: FloatArray, value: FloatArray, error: FloatArray | None,
    least: FloatArray | None = None, most: FloatArray | None = None,
) -> None:  # fmt: skip
    import matplotlib
    from matplotlib.ticker import MaxNLocator

    colour = matplotlib.colormaps[COLOURS](0.35)
    known = np.isfinite(value)
    axes.plot(way, value, color=QUIET, linewidth=0.6, zorder=1)
    axes.plot(way[known], value[known], "o", color=colour, markersize=2.2, markeredgewidth=0,
              zorder=3)  # fmt: skip
    if error is not None and np.isfinite(error[known]).any():
        axes.errorbar(way[known], value[known], yerr=np.nan_to_num(error[known]), fmt="none",
                      ecolor=INK, elinewidth=0.5, zorder=2)  # fmt: skip
    for end, mark in ((least, "^"), (most, "v")):
        if end is not None:
            axes.plot(way, end, mark, color=QUIET, markersize=2.6, markerfacecolor="none",
                      markeredgewidth=0.5, zorder=3)  # fmt: skip
    drawn = np.concatenate([one for one in (value, least, most) if one is not None])
    drawn = drawn[np.isfinite(drawn)]
    top = float(drawn.max()) if len(drawn) else 1.0
    low = min(float(drawn.min()) if len(drawn) else 0.0, 0.0)
    axes.set_ylim(low - 0.06 * (top - low or 1), top + 0.34 * (top - low or 1))
    axes.yaxis.set_major_locator(MaxNLocator(nbins=3, prune="upper"))
