"""Calibration curves as a page shows them: standards, band, what each is by the others, and its leverage."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..calibration.calibration import AREA, WHOLE, Calibration, ElementCalibration
from ..calibration.curve import TWO_SIDED_95, quantile
from ..lines.air import to_air
from .paper import INK, QUIET, SMALL, TWO_COLUMNS_IN, place
from .series import ALONE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLUMNS, CELL_IN, ROW_IN, GAP_IN = 3, TWO_COLUMNS_IN / 3, 2.85, 0.09
CURVE_IN, RESIDUAL_IN, LEVERAGE_IN = 1.25, 0.5, 0.33
HIGH = 2.0  # times the mean leverage, above which a standard bears much of the curve alone
STAGE = {1: "I", 2: "II"}
UNIT = {AREA: "counts nm", WHOLE: "left out, wt %"}  # of the signal; a ratio else


def calibration_figure(calibration: Calibration) -> Figure:
    """A panel for each element: signal against wt %, below it the error when left out, and the leverage."""
    from matplotlib.figure import Figure

    elements = calibration.elements
    rows = -(-len(elements) // COLUMNS)
    figure = Figure(figsize=(CELL_IN * min(len(elements), COLUMNS), ROW_IN * rows))
    for k, (name, one) in enumerate(elements.items()):
        left, bottom = (k % COLUMNS) * CELL_IN + 0.55, ROW_IN * (rows - 1 - k // COLUMNS) + 0.38
        _panel(figure, name, one, left, bottom)
    return figure


def _panel(figure: Figure, name: str, one: ElementCalibration, left: float, bottom: float) -> None:
    curve, points = one.curve, one.points
    c = np.array([p.wt_percent for p in points])
    signal = np.array([p.signal for p in points])
    scatter = np.array([(p.scatter or 0.0) for p in points])
    wide = CELL_IN - 0.65
    above = bottom + LEVERAGE_IN + GAP_IN
    top = place(figure, left, above + RESIDUAL_IN + GAP_IN, wide, CURVE_IN)
    below = place(figure, left, above, wide, RESIDUAL_IN)
    lever = place(figure, left, bottom, wide, LEVERAGE_IN)
    grid = np.linspace(0.0, min(1.08 * curve.highest, curve.top), 200)
    middle = curve.signal(grid)
    band = quantile(TWO_SIDED_95, curve.freedom) * curve.sigma(grid)
    top.fill_between(grid, middle - band, middle + band, color=QUIET, alpha=0.2, linewidth=0)
    top.plot(grid, middle, color=INK)
    top.errorbar(c, signal, yerr=scatter, fmt="o", color=ALONE, markersize=3, elinewidth=0.6)
    top.axvline(curve.lod(), color=QUIET, linewidth=0.6, linestyle=":")
    top.set_ylim(min(0.0, float((signal - scatter).min())), 1.15 * float((signal + scatter).max()))
    for axes in (top, below):
        axes.tick_params(labelbottom=False)
    top.ticklabel_format(axis="y", scilimits=(-2, 4))
    top.yaxis.get_offset_text().set_fontsize(SMALL)
    top.set_title(f"{name} {_signal(one)}", fontsize=SMALL, pad=3)
    below.axhline(0.0, color=INK, linewidth=0.5)
    below.plot(c, [p.cross_validated - p.wt_percent for p in points], "o", color=ALONE)
    if one.pls is None:
        leverage = curve.leverage(c, np.array([float(p.shots) for p in points]))
        lever.plot(c, leverage, "o", color=ALONE, markersize=3)
        lever.axhline(HIGH * leverage.mean(), color=QUIET, linewidth=0.6, linestyle=":")
    else:
        lever.text(
            0.5, 0.5, "T² of spectra", transform=lever.transAxes, ha="center", fontsize=SMALL
        )
    lever.set_ylim(0.0, 1.05)
    for axes in (top, below, lever):
        axes.yaxis.set_label_coords(-0.24, 0.5)
        axes.set_xlim(-0.03 * curve.highest, 1.08 * curve.highest)
    top.set_ylabel(UNIT.get(one.by, "ratio"), fontsize=SMALL)
    below.set_ylabel("left out", fontsize=SMALL)
    lever.set_ylabel("leverage", fontsize=SMALL)
    lever.set_xlabel(f"wt %; LOD {one.lod:.2g}, RMSECV {one.rmsecv:.2g}, band 95 %", fontsize=SMALL)


def _signal(one: ElementCalibration) -> str:
    if one.line is None:
        return f"{one.by}, {one.pls.components if one.pls else 0} components"
    nm = float(to_air(np.array([one.line.wavelength_nm]))[0])
    return f"{STAGE[one.line.stage]} {nm:.2f} nm, {one.by}"
