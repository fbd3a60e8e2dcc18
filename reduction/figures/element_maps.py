"""Element maps side by side at one scale, with one scale bar and one colour bar, or one a map."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..maps.maps import ElementMap
from .layout import MARGIN_IN, Layout, lay_out
from .map_panel import draw_cells, extent, hole_key, scale_bar
from .paper import COLOURS, QUIET, SMALL, paper, place, save, short, write
from .robust import Limits, robust_limits

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOOTER_IN, HEADING_IN = 0.42, 0.2
RANGE_IN, BAR_IN = 0.13, 0.29  # below each panel: its range, or its own colour bar
COLOUR_BAR_IN = 1.55
LEAST_BAR_IN = 0.7  # room for two numbers
COLOUR_LABEL = "the range below each map"


def draw_element_maps(
    maps: Mapping[str, ElementMap], path: Path, title: str = "", unit: str = "mm"
) -> Path:
    """Draw one panel a map, each on its own range (see `robust_limits`), into a file.

    maps: panel title -> map, all of one sample, coordinates in `unit`. The format is that of the
    path's suffix (.png, .svg, .pdf). Gives the path back. Raises ValueError without a map.
    """
    with paper():
        return save(element_maps_figure(maps, title, unit), path)


def element_maps_figure(
    maps: Mapping[str, ElementMap],
    title: str = "",
    unit: str = "mm",
    own_bars: str | None = None,
    limits: Mapping[str, Limits] | None = None,
    below: Mapping[str, str] | None = None,
    below_in: str = "",
) -> Figure:
    """The figure itself, for those who want to draw more into it.

    own_bars: a unit, where each map is to have a colour bar of its own in that unit; one bar for
    the ranges below the maps if None. limits: of the colours by title, `robust_limits` of the map
    where not said. below: the range in words under each map; what lies beyond is added.
    below_in: the unit of these ranges.
    """
    if not maps:
        raise ValueError("there is no map to draw")
    import matplotlib
    from matplotlib.figure import Figure

    first = next(iter(maps.values()))
    under = RANGE_IN if own_bars is None else BAR_IN
    layout = lay_out(len(maps), *extent(first), under, FOOTER_IN, HEADING_IN if title else 0.0)
    figure = Figure(figsize=layout.size)
    colours = matplotlib.colormaps[COLOURS]
    mesh, holes = None, False
    for index, (name, element_map) in enumerate(maps.items()):
        left, bottom, width, height = layout.at(index)
        panel = place(figure, left, bottom, width, height)
        scale = usable((limits or {}).get(name) or robust_limits(element_map.values))
        mesh = draw_cells(panel, element_map, colours, scale.lowest, scale.highest)
        panel.set_title(name, pad=3)
        holes |= bool(np.isnan(element_map.values).any())
        if own_bars is None:
            said = (below or {}).get(name, f"{short(scale.lowest)} to {short(scale.highest)}")
            said = "; ".join(filter(None, (said, scale.said)))
            write(figure, left + width / 2, bottom - 0.035, said, fontsize=5.5, color=QUIET,
                  ha="center", va="top")  # fmt: skip
        else:
            draw_own_bar(figure, mesh, left, bottom, width, scale)
    if title:
        write(figure, MARGIN_IN, layout.size[1] - MARGIN_IN, title, fontweight="bold", va="top")
    label = COLOUR_LABEL + (f" ({below_in})" if below_in else "")
    _footer(figure, layout, unit, first, holes, mesh, own_bars, label)
    return figure


def usable(found: Limits) -> Limits:
    """The same, or one of width 1 where the values are all alike."""
    return found if found.highest > found.lowest else Limits(found.lowest, found.lowest + 1.0)


def draw_own_bar(figure: Figure, mesh, left, bottom, width, scale: Limits) -> None:
    """A colour bar below the panel at left, bottom (inches), with the ends of its scale."""
    left, width = min(left, left + (width - LEAST_BAR_IN) / 2), max(width, LEAST_BAR_IN)
    bar = figure.colorbar(
        mesh, cax=place(figure, left, bottom - 0.1, width, 0.06), orientation="horizontal",
        ticks=[scale.lowest, scale.highest],
    )  # fmt: skip
    _plain(bar)
    low = short(scale.lowest) + (f" ({scale.below} below)" if scale.below else "")
    high = short(scale.highest) + (f" ({scale.above} above)" if scale.above else "")
    bar.ax.set_xticklabels([low, high])
    for text, side in zip(bar.ax.get_xticklabels(), ("left", "right"), strict=True):
        text.set_horizontalalignment(side)


def _footer(
    figure: Figure, layout: Layout, unit, element_map, holes, mesh, own_bars, label
) -> None:
    line = MARGIN_IN + 0.1
    across, _ = extent(element_map)
    end = scale_bar(figure, MARGIN_IN + 0.02, line, layout.scale, unit, max(across, 1e-12))
    right = layout.size[0] - MARGIN_IN - 0.03
    if own_bars is None:
        bar = figure.colorbar(
            mesh, cax=place(figure, right - COLOUR_BAR_IN, line + 0.05, COLOUR_BAR_IN, 0.07),
            orientation="horizontal", ticks=[],
        )  # fmt: skip
        _plain(bar)
        for x, text, side in ((right - COLOUR_BAR_IN, "0", "left"), (right, "1", "right")):
            write(figure, x, line + 0.015, text, fontsize=SMALL, va="top", ha=side)
        write(figure, right, line + 0.15, label, fontsize=SMALL, va="bottom", ha="right")
    else:
        write(figure, right, line, own_bars, fontsize=SMALL, ha="right", va="bottom")
    if holes:
        hole_key(figure, max(end, MARGIN_IN + 0.45) + 0.2, line - 0.05)


def _plain(bar) -> None:
    bar.outline.set_linewidth(0.4)
    bar.ax.tick_params(labelsize=5.5, length=0, pad=1.5)
