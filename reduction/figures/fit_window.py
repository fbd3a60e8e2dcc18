"""A part of a spectrum with the fitted peaks, their sum, and the residual."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..peaks.render import render
from ..reduce import Reduction
from .paper import CLASS_COLOURS, INK, ONE_COLUMN_IN, QUIET, SMALL, place
from .peak_names import peak_names
from .spread import spread

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEFT_IN, RIGHT_IN, BOTTOM_IN = 0.55, 0.1, 0.38
TOP_AXES_IN, LOWER_AXES_IN, GAP_IN, BAND_IN = 1.75, 0.5, 0.06, 0.62
WIDTHS = 14.0  # full widths of a peak that are shown to either side
LEAST_NM, MOST_NM = 0.7, 4.0
MOST_NAMES, NAME_IN = 20, 0.1
FAINT = 0.01  # of its height: below it the foot of a single peak is not drawn


def window_around(reduction: Reduction, near_nm: float | None = None) -> tuple[float, float]:
    """A stretch to look at: around the peak nearest to a place, else around the clearest peak."""
    peaks = reduction.peaks
    if not len(peaks):
        middle = near_nm if near_nm is not None else 0.0
        return middle - LEAST_NM, middle + LEAST_NM
    if near_nm is None:
        at = int(np.argmax(peaks.area / np.maximum(peaks.area_error, 1e-12)))
    else:
        at = int(np.argmin(np.abs(peaks.centre_nm - near_nm)))
    half = float(np.clip(WIDTHS * peaks.fwhm_nm[at], LEAST_NM, MOST_NM))
    return float(peaks.centre_nm[at]) - half, float(peaks.centre_nm[at]) + half


def fit_figure(reduction: Reduction, window_nm: tuple[float, float]) -> Figure:
    """Counts, fit and peaks above; the residual, in standard deviations, below.

    Raises ValueError where the spectrum has fewer than three channels in the window.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    x = reduction.profiles.wavelength_nm
    inside = slice(*np.searchsorted(x, window_nm))
    if inside.stop - inside.start < 3:
        raise ValueError(
            f"the spectrum has fewer than 3 channels from {window_nm[0]:g} to {window_nm[1]:g} nm; "
            f"it covers {x[0]:g} to {x[-1]:g} nm"
        )
    height = BOTTOM_IN + LOWER_AXES_IN + GAP_IN + TOP_AXES_IN + BAND_IN
    figure = Figure(figsize=(ONE_COLUMN_IN, height))
    across = ONE_COLUMN_IN - LEFT_IN - RIGHT_IN
    upper_at = BOTTOM_IN + LOWER_AXES_IN + GAP_IN
    upper = place(figure, LEFT_IN, upper_at, across, TOP_AXES_IN)
    lower = place(figure, LEFT_IN, BOTTOM_IN, across, LOWER_AXES_IN)
    profiles, peaks = reduction.profiles, reduction.peaks
    under, noise = profiles.under[inside], profiles.noise[inside]
    model = under + render(x, peaks, 0.05 * profiles.noise)[inside]
    upper.plot(x[inside], profiles.counts[inside], "o", color=INK, markersize=1.6,
               markeredgewidth=0, label="counts")  # fmt: skip
    fine = np.linspace(*window_nm, 800)
    ground = np.interp(fine, x, profiles.under)
    faint = np.full(len(fine), 1e-3 * float(np.min(noise)))
    upper.plot(fine, ground + render(fine, peaks, faint), color=CLASS_COLOURS[5], zorder=3,
               label="fit")  # fmt: skip
    upper.plot(fine, ground, color=QUIET, linewidth=0.6, linestyle=(0, (4, 2)), label="background")
    shown = np.flatnonzero(
        (peaks.centre_nm > window_nm[0]) & (peaks.centre_nm < window_nm[1])
    )  # fmt: skip
    for k in shown if len(shown) > 1 else ():
        one = render(fine, peaks.where(np.array([k])), faint)
        one[one < FAINT * one.max(initial=0.0)] = np.nan
        upper.plot(fine, ground + one, color=CLASS_COLOURS[0], linewidth=0.5)
    left = (profiles.counts[inside] - model) / noise
    lower.axhspan(-1, 1, color="#e2e2e2", linewidth=0)
    lower.plot(x[inside], left, color=INK, linewidth=0.6, drawstyle="steps-mid")
    lower.set_ylim(
        -1.05 * max(3.5, float(np.max(np.abs(left)))), 1.05 * max(3.5, float(np.max(np.abs(left))))
    )
    lower.yaxis.set_major_locator(MaxNLocator(3, integer=True, symmetric=True))
    for axes in (upper, lower):
        axes.set_xlim(*window_nm)
        axes.xaxis.set_major_locator(MaxNLocator(5))
    upper.tick_params(labelbottom=False)
    upper.yaxis.set_major_locator(MaxNLocator(5))
    upper.margins(y=0.06)
    lower.set_xlabel(f"wavelength in {reduction.medium} (nm)")
    middles = upper_at + TOP_AXES_IN / 2, BOTTOM_IN + LOWER_AXES_IN / 2
    for text, middle in zip(("intensity (counts)", "residual / σ"), middles, strict=True):
        figure.text(0.1 / ONE_COLUMN_IN, middle / height, text, rotation=90, va="center",
                    ha="center", fontsize=SMALL)  # fmt: skip
    upper.legend(loc="upper left", borderaxespad=0.4, labelspacing=0.25)
    _say_main(upper, reduction, shown)
    _names(figure, reduction, shown, window_nm, upper_at + TOP_AXES_IN, across)
    return figure


def _say_main(axes, reduction: Reduction, shown) -> None:
    peaks = reduction.peaks
    if not len(shown):
        return
    k = shown[np.argmax(peaks.area[shown])]
    said = (
        f"{peaks.centre_nm[k]:.3f} nm\n"
        f"area {peaks.area[k]:.4g} ± {peaks.area_error[k]:.2g}\n"
        f"FWHM {1e3 * peaks.fwhm_nm[k]:.0f} pm\n"
        rf"$\chi^2_\nu$ {peaks.chi2[k]:.2f}"
    )
    axes.text(0.97, 0.95, said, transform=axes.transAxes, ha="right", va="top", fontsize=SMALL,
              linespacing=1.3)  # fmt: skip


def _names(figure, reduction: Reduction, shown, window_nm, top, across) -> None:
    from matplotlib.lines import Line2D

    peaks, names = reduction.peaks, peak_names(reduction)
    bright = sorted(shown, key=lambda k: -peaks.area[k])[:MOST_NAMES]
    chosen = sorted(bright, key=lambda k: peaks.centre_nm[k])
    wide, tall = figure.get_size_inches()
    at = LEFT_IN + (peaks.centre_nm[chosen] - window_nm[0]) / np.diff(window_nm) * across
    put = spread(at, NAME_IN, LEFT_IN + NAME_IN / 2, LEFT_IN + across - NAME_IN / 2)
    for k, here, there in zip(chosen, at, put, strict=True):
        figure.add_artist(
            Line2D(np.array([here, here, there]) / wide,
                   np.array([top, top + 0.03, top + 0.1]) / tall, color=QUIET, linewidth=0.4)
        )  # fmt: skip
        figure.text(there / wide, (top + 0.115) / tall, names[k] or "?", rotation=90,
                    fontsize=5.2, ha="center", va="bottom")  # fmt: skip
