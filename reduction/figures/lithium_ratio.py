"""The paper's thermometer: Li I 610 / 670 against temperature, with what was measured."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..plasma.lithium import ratio_curve
from ..spectrum.spectrum import FloatArray
from .paper import INK, ONE_COLUMN_IN, place
from .robust import robust_limits
from .series import ROW_IN, Series, draw_series, key_above

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COOLEST_K, HOTTEST_K = 5_000.0, 16_000.0


def lithium_ratio_figure(
    temperature_k: Series, ratio: Series, labels: FloatArray | None = None,
    names: Mapping[int, str] | None = None,
) -> Figure:  # fmt: skip
    """Ratio of areas against the plasma's temperature; points above the curve absorb themselves.

    temperature_k: from the Saha-Boltzmann plot, which does not use the ratio. labels: classes from
    0 that colour the points; names: of the classes.
    """
    from matplotlib.figure import Figure

    entries = 2 if labels is None else 1 + len(np.unique(labels[np.isfinite(ratio.value)]))
    rows = -(-entries // 2)
    figure = Figure(figsize=(ONE_COLUMN_IN, 2.6 + ROW_IN * (rows + 1)))
    axes = place(figure, 0.48, 0.38, ONE_COLUMN_IN - 0.58, 2.12)
    known = temperature_k.value[np.isfinite(temperature_k.value)]
    first = min(COOLEST_K, float(known.min(initial=COOLEST_K)) - 500)
    last = max(HOTTEST_K, float(known.max(initial=HOTTEST_K)) + 500)
    grid = np.linspace(first, last, 300)
    axes.plot(grid, ratio_curve(grid), color=INK, linewidth=1.0, label="thin plasma, Boltzmann")
    draw_series(axes, temperature_k, ratio, labels, "measured", names)
    axes.set_xlim(first, last)
    shown = robust_limits(ratio.value)
    axes.set_ylim(0, 1.12 * max(shown.highest, float(ratio_curve(np.array([last]))[0])))
    beyond = int(np.sum(ratio.value > axes.get_ylim()[1]))
    axes.set_xlabel("plasma temperature (K)")
    axes.set_ylabel(
        "Li I area ratio, 610.4 nm / 670.8 nm" + (f"; {beyond} above" if beyond else "")
    )
    key_above(figure, 0.48, rows, 2, "above the curve: 670.8 nm absorbs itself")
    return figure
