"""Lithium's share against temperature: of one plasma as it would be at others, or of many points."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..spectrum.spectrum import FloatArray
from .paper import INK, ONE_COLUMN_IN, QUIET, SMALL, place
from .series import Series, draw_series

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARGIN_K = 1_500.0


def lithium_share_figure(
    temperature_k: Series,
    share: Series,
    labels: FloatArray | None = None,
    curve: tuple[FloatArray, FloatArray, FloatArray, FloatArray] | None = None,
    elements: tuple[str, ...] = (),
) -> Figure:
    """Share by atoms. curve: temperatures in K, the share that the same light would mean there,
    and its lower and upper edge from the error of the density; shapes (k,). elements: the cations."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(ONE_COLUMN_IN, 2.6))
    axes = place(figure, 0.5, 0.38, ONE_COLUMN_IN - 0.6, 2.12)
    if curve is not None:
        kelvin, middle, low, high = curve
        axes.fill_between(kelvin, low, high, color="#c9c9c9", linewidth=0,
                          label="error of the density")  # fmt: skip
        axes.plot(kelvin, middle, color=INK, label="what this light means at T")
        axes.set_xlim(kelvin[0], kelvin[-1])
    draw_series(axes, temperature_k, share, labels, "at the plasma's temperature")
    known = temperature_k.value[np.isfinite(temperature_k.value) & np.isfinite(share.value)]
    if curve is None and len(known):
        axes.set_xlim(known.min() - MARGIN_K / 5, known.max() + MARGIN_K / 5)
    top = float(np.nanmax(share.value, initial=0.0))
    top = max(top, 0.0 if curve is None else float(curve[3].max()))
    axes.set_ylim(0 if curve is not None else -0.03 * (top or 1), 1.25 * top or 1.0)
    axes.set_xlabel("plasma temperature (K)")
    axes.set_ylabel("Li fraction of the cations (atoms)")
    if curve is not None or labels is not None:
        axes.legend(loc="upper right", borderaxespad=0.4, ncols=1 if labels is None else 3,
                    columnspacing=0.8, handletextpad=0.1 if labels is not None else 0.5)  # fmt: skip
    if elements:
        axes.text(0.97, 0.05, "cations: " + ", ".join(elements), fontsize=SMALL, color=QUIET,
                  ha="right", transform=axes.transAxes)  # fmt: skip
    return figure
