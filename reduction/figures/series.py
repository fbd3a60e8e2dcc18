"""Measured points with their errors, coloured by class where they have one."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..spectrum.spectrum import FloatArray
from .paper import INK, QUIET, SMALL, class_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ALONE = "#D55E00"
ROW_IN = 0.125  # of a legend
MANY = 60  # points from which on errors are drawn faintly


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """value and its standard error, shape (n,); NaN where unknown."""

    value: FloatArray
    error: FloatArray


def draw_series(
    axes: Axes, x: Series, y: Series, labels: FloatArray | None = None, name: str = "measured",
    names: Mapping[int, str] | None = None,
) -> int:  # fmt: skip
    """Draw the points that have both coordinates; how many these are.

    labels: classes from 0, below 0 for none; names: of the classes.
    """
    known = np.isfinite(x.value) & np.isfinite(y.value)
    n = int(np.sum(known))
    if not n:
        return 0
    classes = np.full(len(known), -1.0) if labels is None else labels
    for label in np.unique(classes[known]):
        own = known & (classes == label)
        colour = ALONE if label < 0 else class_colour(int(label))
        axes.errorbar(
            x.value[own], y.value[own], xerr=_errors(x.error[own]), yerr=_errors(y.error[own]),
            fmt="none", ecolor=colour, elinewidth=0.5, alpha=0.25 if n > MANY else 0.9, zorder=2,
        )  # fmt: skip
        axes.plot(
            x.value[own], y.value[own], "o", color=colour, markersize=2.6 if n > MANY else 4.0,
            markeredgecolor=INK, markeredgewidth=0.25, zorder=3, linestyle="none",
            label=name if labels is None else _class(int(label), names or {}),
        )  # fmt: skip
    return n


def _class(label: int, names: Mapping[int, str]) -> str:
    if label < 0:
        return "no class"
    return f"{label + 1} {names[label]}" if label in names else f"class {label + 1}"


def key_above(figure: Figure, left: float, rows: int, columns: int, said: str = "") -> None:
    """The legend over the axes, clear of the points, and a line of words above it.

    left: in inches; rows: of the legend; columns: of it.
    """
    across, up = figure.get_size_inches()
    top = 1 - 0.04 / up
    if said:
        figure.text(left / across, top, said, fontsize=SMALL, color=QUIET, va="top")
        top -= ROW_IN / up
    if rows:
        figure.legend(loc="upper left", bbox_to_anchor=(left / across, top), ncols=columns,
                      borderaxespad=0.0, handletextpad=0.3, labelspacing=0.25,
                      columnspacing=0.9)  # fmt: skip


def _errors(error: FloatArray) -> FloatArray:
    return np.nan_to_num(error).clip(0)
