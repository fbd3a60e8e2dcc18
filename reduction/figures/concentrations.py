"""Maps in weight per cent, each with the map of its standard error beside it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..maps.maps import ElementMap
from .element_maps import draw_own_bar, usable
from .layout import MARGIN_IN, lay_out
from .map_panel import draw_cells, extent, hole_key, scale_bar
from .paper import COLOURS, HEAT, place, write
from .robust import robust_limits

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FOOTER_IN, HEADING_IN, UNDER_IN = 0.42, 0.2, 0.29
LEAST_IN, APART = 0.9, 1.04  # from a map to the one beside it, inches at least; in its width
BELOW_COLOUR, ABOVE_COLOUR = "#ffffff", "#ff3b8d"  # in neither of the two scales of colours
BELOW_SAID, ABOVE_SAID = "below LOD", "above the standards"


@dataclass(frozen=True, slots=True, eq=False)
class ContentMaps:
    """value and error in wt %, NaN where there is none; below and above: 1 where that is why."""

    value: ElementMap
    error: ElementMap
    below: ElementMap
    above: ElementMap


def concentrations_figure(
    maps: Mapping[str, ContentMaps], title: str = "", unit: str = "mm"
) -> Figure:
    """maps: by element, all of one sample. Raises ValueError without a map."""
    if not maps:
        raise ValueError("there is no map to draw")
    import matplotlib
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure

    first = next(iter(maps.values())).value
    across, up = extent(first)
    layout = lay_out(
        len(maps), 2 * APART * across, up, UNDER_IN, FOOTER_IN, HEADING_IN if title else 0.0,
        narrowest=2 * LEAST_IN,
    )  # fmt: skip
    figure = Figure(figsize=layout.size)
    wide = across * layout.scale
    apart = max(APART * wide, LEAST_IN) / 2
    for index, (element, one) in enumerate(maps.items()):
        left, bottom, width, height = layout.at(index)
        for side, shown, what, colours in (
            (-1, one.value, "wt %", COLOURS), (1, one.error, "error, wt %", HEAT)
        ):  # fmt: skip
            at = left + width / 2 + side * apart - wide / 2
            panel = place(figure, at, bottom, wide, height)
            scale = usable(robust_limits(shown.values))
            for flat, colour in ((one.below, BELOW_COLOUR), (one.above, ABOVE_COLOUR)):
                flat_colour = ListedColormap([colour])
                draw_cells(panel, flat, flat_colour, 0.0, 1.0)
            mesh = draw_cells(
                panel, shown, matplotlib.colormaps[colours], scale.lowest, scale.highest
            )
            panel.set_title(rf"$\bf{{{element}}}$ {what}", pad=3)
            if np.isfinite(shown.values).any():
                draw_own_bar(figure, mesh, at, bottom, wide, scale)
    if title:
        write(figure, MARGIN_IN, layout.size[1] - MARGIN_IN, title, fontweight="bold", va="top")
    line = MARGIN_IN + 0.1
    end = scale_bar(figure, MARGIN_IN + 0.02, line, layout.scale, unit, max(across, 1e-12))
    _keys(figure, maps, max(end, MARGIN_IN + 0.45) + 0.2, line - 0.05)
    return figure


def _keys(figure: Figure, maps: Mapping[str, ContentMaps], x: float, y: float) -> None:
    """What the cells without a value mean, as far as there are any."""
    below, above, hole = False, False, False
    for one in maps.values():
        states = [np.isfinite(each.values) for each in (one.below, one.above, one.value)]
        below |= bool(states[0].any())
        above |= bool(states[1].any())
        hole |= not np.any(states, axis=0).all()
    for there, said, colour in (
        (below, BELOW_SAID, BELOW_COLOUR), (above, ABOVE_SAID, ABOVE_COLOUR), (hole, "", ""),
    ):  # fmt: skip
        if there:
            x = (hole_key(figure, x, y, said, colour) if said else hole_key(figure, x, y)) + 0.1
