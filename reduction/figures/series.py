"""Measured points with their errors, coloured by class where they have one."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..spectrum.spectrum import FloatArray
from .paper import INK, class_colour

if TYPE_CHECKING:
    from matplotlib.axes import Axes

ALONE = "#D55E00"
MANY = 60  # points from which on errors are drawn faintly


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """value and its standard error, shape (n,); NaN where unknown."""

    value: FloatArray
    error: FloatArray


def draw_series(
    axes: Axes, x: Series, y: Series, labels: FloatArray | None = None, name: str = "measured"
) -> int:
    """Draw the points that have both coordinates; how many these are."""
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
            label=name if labels is None else f"class {int(label) + 1}" if label >= 0 else None,
        )  # fmt: skip
    return n


def _errors(error: FloatArray) -> FloatArray:
    return np.nan_to_num(error).clip(0)
