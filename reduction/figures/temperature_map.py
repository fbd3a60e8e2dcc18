"""A map of the plasma temperature, one panel per sample."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..maps.maps import ElementMap
from ..spectrum.spectrum import FloatArray
from .layout import MARGIN_IN, lay_out
from .map_panel import draw_cells, extent, hole_key, largest_extent, scale_bar
from .paper import HEAT, SMALL, place, write
from .robust import robust_limits

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOOTER_IN = 0.46
BAR_IN, HALF_LABEL_IN = 1.4, 0.12  # the bar; what its last label needs beside it
HEADING_IN = 0.3


def temperature_map_figure(
    maps: dict[str, ElementMap], unit: str = "mm", error_k: FloatArray | None = None
) -> Figure:
    """maps: temperature in K by the sample's title. error_k: standard errors of the points, any
    shape. Raises ValueError where no temperature is known."""
    import matplotlib
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator, StrMethodFormatter

    values = np.concatenate([one.values.ravel() for one in maps.values()])
    known = values[np.isfinite(values)]
    if not len(known):
        raise ValueError("there is no temperature to draw")
    largest = largest_extent(maps.values())
    layout = lay_out(len(maps), *largest, 0.0, FOOTER_IN, HEADING_IN)
    figure = Figure(figsize=layout.size)
    scale = robust_limits(known)
    lowest, highest = scale.lowest, max(scale.highest, scale.lowest + 1.0)
    mesh = None
    for index, (name, one) in enumerate(maps.items()):
        panel = place(figure, *layout.of_smaller(index, *extent(one)))
        mesh = draw_cells(panel, one, matplotlib.colormaps[HEAT], lowest, highest)
        panel.set_title(name, pad=3)
    line = MARGIN_IN + 0.1
    end = scale_bar(figure, layout.at(0)[0], line, layout.scale, unit, max(largest[0], 1e-12))
    if len(known) < len(values):
        hole_key(figure, max(end, layout.at(0)[0] + 0.4) + 0.15, line - 0.05, "not known")
    right = layout.at(layout.columns - 1 if layout.rows > 1 else len(maps) - 1)
    edge = min(max(right[0] + right[2], 2.8), layout.size[0] - MARGIN_IN - HALF_LABEL_IN)
    bar = figure.colorbar(
        mesh,  # pyright: ignore[reportArgumentType]
        cax=place(figure, edge - BAR_IN, line + 0.06, BAR_IN, 0.07),
        orientation="horizontal",
    )
    bar.outline.set_linewidth(0.4)  # pyright: ignore[reportCallIssue]
    bar.ax.xaxis.set_major_locator(MaxNLocator(4))
    bar.ax.xaxis.set_major_formatter(StrMethodFormatter("{x:,.0f}"))
    bar.ax.tick_params(labelsize=5.5, length=1.5, width=0.4, pad=1.5)
    label = "plasma temperature (K)" + (f"; {scale.said}" if scale.said else "")
    write(figure, edge - BAR_IN, line + 0.16, label, fontsize=SMALL)
    write(figure, MARGIN_IN, layout.size[1] - MARGIN_IN, _title(known, error_k), va="top",
          fontsize=SMALL, linespacing=1.35)  # fmt: skip
    return figure


def _title(known: FloatArray, error_k: FloatArray | None) -> str:
    """The median, and how well one point tells it."""
    told = f"plasma temperature, median {np.median(known):,.0f} K of {len(known):,} points"
    errors = np.empty(0) if error_k is None else error_k[np.isfinite(error_k)]
    if not len(errors):
        return f"{told}\nstandard errors not known"
    low, middle, high = np.quantile(errors, [0.16, 0.5, 0.84])
    return (
        f"{told}\nstandard error of a point: median ± {middle:,.0f} K, "
        f"for two thirds ± {low:,.0f} to {high:,.0f} K"
    )
