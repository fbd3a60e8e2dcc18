"""How standards lie among one another by their whole spectra, and which wavelengths PLS models read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..calibration.calibration import Calibration
from ..calibration.multivariate import ORDINARY, Likeness, unpacked
from .paper import INK, QUIET, SMALL, TWO_COLUMNS_IN, place
from .series import ALONE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEFT_IN, APART_IN, TOP_IN, UNDER_IN, MAP_IN, ROW_IN, GAP_IN = 0.55, 0.75, 0.15, 0.42, 2.2, 0.6, 0.1
NAMED = 24  # standards that are named in the plot of scores; of more, those that lie outside


def whole_spectra_figure(calibration: Calibration) -> Figure:
    """Scores, T2 and Q of the standards; below them the importance (VIP) along the axis of each element
    that is read from the whole spectrum. Raises ValueError for a calibration without a model of spectra."""
    likeness = calibration.likeness
    if likeness is None:
        raise ValueError("this calibration has no model of whole spectra")
    from matplotlib.figure import Figure

    models = {name: one.pls for name, one in calibration.elements.items() if one.pls is not None}
    below = len(models) * (ROW_IN + GAP_IN) + (UNDER_IN if models else 0.0)
    figure = Figure(figsize=(TWO_COLUMNS_IN, TOP_IN + MAP_IN + UNDER_IN + below))
    wide = (TWO_COLUMNS_IN - LEFT_IN - APART_IN - TOP_IN) / 2
    scores = place(figure, LEFT_IN, below + UNDER_IN, wide, MAP_IN)
    far = place(figure, LEFT_IN + wide + APART_IN, below + UNDER_IN, wide, MAP_IN)
    _scores(scores, likeness)
    _far(far, likeness)
    for k, (name, model) in enumerate(models.items()):
        bottom = UNDER_IN + (len(models) - 1 - k) * (ROW_IN + GAP_IN)
        axes = place(figure, LEFT_IN, bottom, TWO_COLUMNS_IN - LEFT_IN - TOP_IN, ROW_IN)
        importance = unpacked(model.importance)
        edges = np.linspace(*calibration.range_nm, len(importance) + 1)
        axes.stairs(importance, edges, color=ALONE, linewidth=0.7)
        axes.axhline(1.0, color=QUIET, linewidth=0.6, linestyle=":")
        axes.set_xlim(edges[0], edges[-1])
        axes.set_ylabel(f"{name} VIP", fontsize=SMALL)
        last = k == len(models) - 1
        axes.tick_params(labelbottom=last)
        if last:
            axes.set_xlabel("wavelength (nm)")
    return figure


def _scores(axes: Axes, likeness: Likeness) -> None:
    x, y = np.array([one.scores for one in likeness.places]).T
    out = [max(one.t2 / likeness.t2_limit, one.q / likeness.q_limit) > 1 for one in likeness.places]
    axes.plot(x, y, "o", color=ALONE, markersize=3)
    for one, beyond in zip(likeness.places, out, strict=True):
        if beyond or len(out) <= NAMED:
            axes.annotate(
                one.sample, one.scores, (3, 2), textcoords="offset points", fontsize=SMALL
            )
    axes.margins(0.15)
    shares = [f"PC {k} ({100 * part:.0f} %)" for k, part in enumerate(likeness.explained, 1)]
    axes.set_xlabel(shares[0])
    axes.set_ylabel(shares[1] if len(shares) > 1 else "")


def _far(axes: Axes, likeness: Likeness) -> None:
    t2 = np.array([one.t2 / likeness.t2_limit for one in likeness.places])
    q = np.array([one.q / likeness.q_limit for one in likeness.places])
    axes.loglog(t2, q, "o", color=ALONE, markersize=3)
    for draw in (axes.axhline, axes.axvline):
        draw(1.0, color=INK, linewidth=0.6, linestyle=":")
    for one, a, b in zip(likeness.places, t2, q, strict=True):
        if max(a, b) > 1:
            axes.annotate(one.sample, (a, b), (3, 2), textcoords="offset points", fontsize=SMALL)
    axes.set_xlabel(f"T² over its {100 * ORDINARY:.0f} % limit, left out")
    axes.set_ylabel("Q over its limit, left out")
