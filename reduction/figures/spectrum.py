"""A spectrum with labelled lines: parts of the axis in rows, names in a band above."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..reduce import Reduction
from ..spectrum.spectrum import FloatArray
from .paper import INK, QUIET, TWO_COLUMNS_IN, place
from .peak_names import peak_names
from .spread import spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

STRETCH_NM, MOST_STRETCHES = 260.0, 3
AXES_IN, BAND_IN, BETWEEN_IN = 1.2, 0.62, 0.2
LEFT_IN, RIGHT_IN, BOTTOM_IN = 0.55, 0.16, 0.38
NAME_IN = 0.088  # that a name takes along the axis
MOST_NAMES = 34
LEAST_HEIGHT = 0.025  # of the highest in the stretch, on a linear scale
ALWAYS = 10  # of the highest in a stretch, named by their wavelengths where by nothing else


def spectrum_figure(reduction: Reduction, log: bool = False) -> Figure:
    """Counts against wavelength, the brightest peaks named by element and stage; log: of counts."""
    from matplotlib.figure import Figure

    x, y = reduction.profiles.wavelength_nm, reduction.profiles.counts
    n = int(np.clip(np.ceil((x[-1] - x[0]) / STRETCH_NM), 1, MOST_STRETCHES))
    names = peak_names(reduction)
    band = BAND_IN if len(names) else 0.05
    row_in = AXES_IN + band + BETWEEN_IN
    height = BOTTOM_IN + n * row_in - BETWEEN_IN + 0.04
    figure = Figure(figsize=(TWO_COLUMNS_IN, height))
    limits = np.linspace(x[0], x[-1], n + 1)
    axes = None
    for row in range(n):
        bottom = BOTTOM_IN + (n - 1 - row) * row_in
        axes = place(figure, LEFT_IN, bottom, TWO_COLUMNS_IN - LEFT_IN - RIGHT_IN, AXES_IN)
        inside = slice(*np.searchsorted(x, [limits[row], limits[row + 1]]))
        axes.plot(x[inside], y[inside], color=INK, linewidth=0.45, rasterized=False)
        axes.set_xlim(limits[row], limits[row + 1])
        _scale(axes, y[inside], log)
        _names(figure, axes, reduction, names, bottom, x, y, log)
    if axes is not None:
        bad = int(np.count_nonzero(reduction.bad.missing | reduction.bad.dead | reduction.bad.hot))
        told = f"; bad channels, bridged: {bad:,}" if bad else ""
        axes.set_xlabel(f"wavelength in {reduction.medium} (nm){told}")
    figure.text(0.1 / TWO_COLUMNS_IN, (height - band + BOTTOM_IN) / 2 / height,
                "intensity (counts)", rotation=90, va="center", ha="center")  # fmt: skip
    return figure


def _scale(axes: Axes, y: FloatArray, log: bool) -> None:
    from matplotlib.ticker import AutoMinorLocator, MaxNLocator

    top = float(np.max(y, initial=1.0))
    if log:
        positive = y[y > 0]
        low = float(np.quantile(positive, 0.01)) if len(positive) else 1.0
        axes.set_yscale("log")
        axes.set_ylim(max(low * 0.7, 1e-3), max(top, low * 2) * 1.4)
    else:
        axes.set_ylim(min(0.0, float(np.min(y, initial=0.0))), 1.06 * max(top, 1e-9))
        axes.yaxis.set_major_locator(MaxNLocator(4))
    axes.xaxis.set_minor_locator(AutoMinorLocator())


def _names(figure: Figure, axes: Axes, reduction: Reduction, names, bottom, x, y, log) -> None:
    from matplotlib.lines import Line2D

    first, last = axes.get_xlim()
    low, high = axes.get_ylim()
    centre = reduction.peaks.centre_nm
    tops = y[np.clip(np.searchsorted(x, centre), 0, len(y) - 1)]
    under = np.interp(centre, x, reduction.profiles.under)
    rise = np.log(np.maximum(tops, 1e-9) / np.maximum(under, 1e-9)) if log else tops - under
    here = np.flatnonzero((centre > first) & (centre < last))
    here = here[log | (rise[here] > LEAST_HEIGHT * (high - low))]
    always = set(here[np.argsort(-rise[here], kind="stable")][:ALWAYS].tolist())
    inside = [k for k in here.tolist() if names[k] or k in always]
    across = TWO_COLUMNS_IN - LEFT_IN - RIGHT_IN
    most = min(MOST_NAMES, int(across / NAME_IN))
    chosen = sorted(sorted(inside, key=lambda k: -rise[k])[:most], key=lambda k: centre[k])
    wide, tall = figure.get_size_inches()
    at = LEFT_IN + (centre[chosen] - first) / (last - first) * across
    put = spread(at, NAME_IN, LEFT_IN + NAME_IN / 2, LEFT_IN + across - NAME_IN / 2)
    to_axes = axes.transData.transform
    for k, here, there in zip(chosen, at, put, strict=True):
        up = to_axes((centre[k], np.clip(tops[k], low, high)))[1] / figure.dpi
        knee, foot = bottom + AXES_IN + 0.03, bottom + AXES_IN + 0.12
        figure.add_artist(
            Line2D(np.array([here, here, there]) / wide, np.array([up + 0.02, knee, foot]) / tall,
                   color=QUIET, linewidth=0.3)
        )  # fmt: skip
        figure.text(there / wide, (foot + 0.015) / tall, names[k] or f"? {centre[k]:.1f}",
                    rotation=90, fontsize=4.8, ha="center", va="bottom")  # fmt: skip
