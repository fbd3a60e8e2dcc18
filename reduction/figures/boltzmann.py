"""The Saha-Boltzmann plot: all lines of all elements on one straight line of slope -1/kT."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..lines.lines import BOLTZMANN_EV_PER_K
from ..plasma.boltzmann import CALIBRATION
from ..plasma.strengths import atoms
from ..reduce import Reduction
from ..tables.plot import lines_of_plot
from .paper import CLASS_COLOURS, INK, ONE_COLUMN_IN, SMALL, place

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARKERS = "osD^vP*Xph"
COLOURS = (*CLASS_COLOURS, "#882255", "#44AA99", "#332288")


def boltzmann_figure(reduction: Reduction) -> Figure:
    """ln(area lambda / gA), amounts and self-absorption taken out, against the upper level's energy.

    Of ions it is the energy above the neutral atom's ground, after Saha. Raises ValueError where
    the spectrum's lines did not tell a temperature.
    """
    lines = lines_of_plot(reduction)
    if lines is None or reduction.identified is None or reduction.identified.plot is None:
        raise ValueError(
            "the lines of this spectrum do not determine a temperature, so there is no plot"
        )
    from matplotlib.figure import Figure

    plot, a = reduction.identified.plot, atoms()
    kt = BOLTZMANN_EV_PER_K * plot.temperature_k
    energy = lines.e_k_ev + np.where(lines.ion, a.limit_ev[lines.element], 0.0)
    ordinate = -energy / kt + plot.residual
    error = np.hypot(lines.error, CALIBRATION)
    elements = np.unique(lines.element)
    key = -(-len(elements) // 5) * 0.125 + 0.08
    height = 2.55 + key
    figure = Figure(figsize=(ONE_COLUMN_IN, height))
    axes = place(figure, 0.5, 0.38, ONE_COLUMN_IN - 0.6, 2.12)
    grid = np.linspace(min(0.0, energy.min()), energy.max() + 0.5, 100)
    axes.plot(grid, -grid / kt, color=INK, linewidth=0.8, zorder=1)
    pivot = float(np.average(energy, weights=1 / error**2))
    tilt = np.abs(grid - pivot) * plot.temperature_error_k / plot.temperature_k / kt
    axes.fill_between(grid, -grid / kt - tilt, -grid / kt + tilt, color="#d9d9d9", linewidth=0,
                      zorder=0)  # fmt: skip
    for order, element in enumerate(elements):
        colour = COLOURS[order % len(COLOURS)]
        marker = MARKERS[order % len(MARKERS)]
        for ion in (False, True):
            own = (lines.element == element) & (lines.ion == ion)
            if not own.any():
                continue
            axes.errorbar(
                energy[own], ordinate[own], yerr=error[own], fmt=marker, color=colour,
                markersize=3.2, markeredgewidth=0.6, markeredgecolor=colour, elinewidth=0.5,
                markerfacecolor="white" if ion else colour,
            )  # fmt: skip
        axes.plot([], [], marker, color=colour, markersize=3.2, label=str(a.elements[element]))
    axes.set_xlim(grid[0] - 0.2, grid[-1])
    axes.set_xlabel("energy of the upper level (eV)")
    axes.set_ylabel(r"ln(area $\lambda$ / $gA$), shifted")
    axes.text(0.96, 0.95, _result(plot), transform=axes.transAxes, ha="right", va="top",
              fontsize=SMALL, linespacing=1.4)  # fmt: skip
    axes.text(0.04, 0.05, "filled: I, open: II", transform=axes.transAxes, fontsize=SMALL)
    figure.legend(loc="upper left", bbox_to_anchor=(0.5 / ONE_COLUMN_IN, 1 - 0.03 / height),
                  ncols=5, borderaxespad=0, handletextpad=0.1, columnspacing=1.0,
                  labelspacing=0.25)  # fmt: skip
    return figure


def _result(plot) -> str:
    return (
        f"$T$ = {plot.temperature_k:,.0f} ± {plot.temperature_error_k:,.0f} K\n"
        rf"log$_{{10}}$($n_e$ / cm$^{{-3}}$) = {plot.log10_ne:.2f} ± {plot.log10_ne_error:.2f}"
        + "\n"
        + rf"$\chi^2_\nu$ = {plot.chi2:.2f}"
    )
