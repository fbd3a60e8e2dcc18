"""One map on a page: cells without axes, a frame, and a scale bar."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..maps.maps import ElementMap
from ..spectrum.spectrum import FloatArray
from .paper import HOLE, INK, SMALL, write

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from matplotlib.colors import Colormap
    from matplotlib.figure import Figure

ROUND_LENGTHS = (1.0, 2.0, 5.0)
MOST_BAR_IN = 1.0


def edges(centres: FloatArray) -> FloatArray:
    """Where the cells around the centres begin and end; shape (n + 1,)."""
    if len(centres) == 1:
        return centres[0] + np.array([-0.5, 0.5])
    between = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate(([2 * centres[0] - between[0]], between, [2 * centres[-1] - between[-1]]))


def extent(element_map: ElementMap) -> tuple[float, float]:
    """Width and height of a map with its outer cells, in its unit."""
    x, y = edges(element_map.x), edges(element_map.y)
    return float(x[-1] - x[0]), float(y[-1] - y[0])


def largest_extent(maps: Iterable[ElementMap]) -> tuple[float, float]:
    """Width and height that hold each of the maps."""
    across, up = zip(*(extent(one) for one in maps), strict=True)
    return max(across), max(up)


def draw_cells(
    panel: Axes, element_map: ElementMap, colours: Colormap, lowest: float, highest: float
) -> QuadMesh:
    """The cells of a map, y upwards; what was not measured shows the panel's grey."""
    mesh = panel.pcolormesh(
        edges(element_map.x), edges(element_map.y), np.ma.masked_invalid(element_map.values),
        cmap=colours, vmin=lowest, vmax=highest, rasterized=True,
    )  # fmt: skip
    panel.set_facecolor(HOLE)
    panel.set_xticks([])
    panel.set_yticks([])
    for spine in panel.spines.values():
        spine.set_linewidth(0.5)
    return mesh


def scale_bar(figure: Figure, x: float, y: float, scale: float, unit: str, most: float) -> float:
    """A bar of a round length with its length over it, left end at x, y inches; where it ends.

    scale: inches per unit; most: units that it may be long.
    """
    from matplotlib.lines import Line2D

    length = round_length(min(most, MOST_BAR_IN / scale))
    across, up = figure.get_size_inches()
    end = x + length * scale
    figure.add_artist(
        Line2D([x / across, end / across], [y / up, y / up], color=INK, linewidth=2.0,
               solid_capstyle="butt")
    )  # fmt: skip
    write(figure, x, y + 0.04, f"{length:g} {unit}", fontsize=SMALL, va="bottom", ha="left")
    return end


def hole_key(
    figure: Figure, x: float, y: float, text: str = "not measured", colour: str = HOLE
) -> float:
    """A square, grey for holes, with what it means, its lower left corner at x, y inches; where it ends."""
    from matplotlib.patches import Rectangle

    across, up = figure.get_size_inches()
    figure.add_artist(
        Rectangle((x / across, y / up), 0.1 / across, 0.1 / up, facecolor=colour, edgecolor=INK,
                  linewidth=0.4, transform=figure.transFigure)
    )  # fmt: skip
    write(figure, x + 0.14, y + 0.05, text, fontsize=SMALL, va="center")
    return x + 0.14 + 0.045 * len(text)


def round_length(most: float) -> float:
    """The longest of ... 0.5, 1, 2, 5, 10 ... that is no longer than `most` (above 0)."""
    decade = 10.0 ** np.floor(np.log10(most))
    return float(max(step * decade for step in ROUND_LENGTHS if step * decade <= most * (1 + 1e-9)))
