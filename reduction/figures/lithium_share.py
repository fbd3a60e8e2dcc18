"""Lithium's share against temperature: of one plasma as it would be at others, or of many points."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..spectrum.spectrum import FloatArray
from .paper import INK, ONE_COLUMN_IN, place
from .robust import robust_limits
from .series import ROW_IN, Series, draw_series, key_above

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MARGIN_K = 1_500.0


def lithium_share_figure(
    temperature_k: Series,
    share: Series,
    labels: FloatArray | None = None,
    curve: tuple[FloatArray, FloatArray, FloatArray, FloatArray] | None = None,
    elements: tuple[str, ...] = (),
    names: Mapping[int, str] | None = None,
) -> Figure:
    """Share by atoms. curve: temperatures in K, the share that the same light would mean there,
    and its lower and upper edge from the error of the density; shapes (k,). elements: the cations.
    names: of the classes in labels."""
    from matplotlib.figure import Figure

    entries = 0 if labels is None else len(np.unique(labels[np.isfinite(share.value)]))
    columns = 2 if labels is not None else 1
    rows = -(-entries // columns) if labels is not None else 3 if curve is not None else 0
    said = f"cations: {', '.join(elements)}" if elements else ""
    above = ROW_IN * (rows + bool(said)) + 0.1
    figure = Figure(figsize=(ONE_COLUMN_IN, 2.5 + above))
    axes = place(figure, 0.5, 0.38, ONE_COLUMN_IN - 0.6, 2.12)
    if curve is not None:
        kelvin, middle, low, high = curve
        axes.fill_between(kelvin, low, high, color="#c9c9c9", linewidth=0,
                          label="error of the density")  # fmt: skip
        axes.plot(kelvin, middle, color=INK, label="what this light means at T")
        axes.set_xlim(kelvin[0], kelvin[-1])
    draw_series(axes, temperature_k, share, labels, "at the plasma's temperature", names)
    known = temperature_k.value[np.isfinite(temperature_k.value) & np.isfinite(share.value)]
    if curve is None and len(known):
        axes.set_xlim(known.min() - MARGIN_K / 5, known.max() + MARGIN_K / 5)
    shown = robust_limits(share.value)
    top = max(shown.highest, 0.0 if curve is None else float(curve[3].max()))
    axes.set_ylim(0 if curve is not None else -0.03 * (top or 1), 1.15 * top or 1.0)
    beyond = int(np.sum(share.value > axes.get_ylim()[1]))
    axes.set_xlabel("plasma temperature (K)")
    axes.set_ylabel("Li fraction of the cations (atoms)" + (f"; {beyond} above" if beyond else ""))
    key_above(figure, 0.5, rows, columns, said)
    return figure
