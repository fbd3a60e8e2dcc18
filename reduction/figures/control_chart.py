"""What check standards read in the course of a run, beside what is known of them."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np

from ..maps.checks import HOLDS, Checks
from .paper import INK, QUIET, SMALL, TWO_COLUMNS_IN, place
from .series import ALONE

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEFT_IN, RIGHT_IN, CHART_IN, ABOVE_IN, BELOW_IN = 0.55, 0.1, 1.0, 0.38, 0.36
WIDE = 118  # characters of a sentence in a line


def control_chart(checks: Sequence[Checks]) -> Figure:
    """A chart for each standard's element, its verdict over it. Raises ValueError without checks."""
    if not checks:
        raise ValueError("there is no check to draw")
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    row = ABOVE_IN + CHART_IN + BELOW_IN
    figure = Figure(figsize=(TWO_COLUMNS_IN, row * len(checks)))
    for k, one in enumerate(checks):
        bottom = row * (len(checks) - 1 - k) + BELOW_IN
        axes = place(figure, LEFT_IN, bottom, TWO_COLUMNS_IN - LEFT_IN - RIGHT_IN, CHART_IN)
        n = np.arange(1, len(one.found) + 1)
        reach = HOLDS * float(np.hypot(one.error_of_one, one.known_error))
        axes.axhspan(one.known - reach, one.known + reach, color=QUIET, alpha=0.15, linewidth=0)
        axes.axhline(one.known, color=INK, linewidth=0.6)
        axes.errorbar(n, one.found, yerr=np.nan_to_num(one.error), fmt="o", color=ALONE,
                      markersize=3, elinewidth=0.6)  # fmt: skip
        axes.set_xlim(0.5, len(n) + 0.5)
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.set_ylabel(f"{one.element} (wt %)")
        axes.set_title(fill(one.sentence, WIDE), fontsize=SMALL, loc="left", pad=3)
        if k == len(checks) - 1:
            axes.set_xlabel(f"check; band: known ± {HOLDS:g} errors of one reading")
    return figure
