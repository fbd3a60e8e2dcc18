"""The map of classes: one colour per class, with its likely mineral beside it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..maps.classes.classify import Classes
from ..maps.classes.minerals import UNNAMED
from ..maps.maps import ElementMap
from .layout import GAP_IN, MARGIN_IN, lay_out
from .map_panel import draw_cells, extent, hole_key, largest_extent, scale_bar
from .paper import INK, SMALL, class_colour, place, write

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LINE_IN = 0.15
KEY_IN = 1.5
FOOTER_IN = 0.3
NO_SIGNAL = "#3b3b3b"


def class_name(classes: Classes, label: int) -> str:
    """What a class is called in a figure: its number, likely mineral and size."""
    summary = classes.summary[label]
    likely = "" if summary.likely == UNNAMED else f" {summary.likely}"
    return f"{summary.number} {likely} ({summary.size})"


def class_map_figure(maps: dict[str, ElementMap], classes: Classes, unit: str = "mm") -> Figure:
    """One panel a sample. maps: by the sample's title; values are labels from 0, NONE for no signal.

    Raises ValueError without a map.
    """
    if not maps:
        raise ValueError("there is no map to draw")
    from matplotlib.colors import ListedColormap
    from matplotlib.figure import Figure

    largest = largest_extent(maps.values())
    values = np.concatenate([one.values.ravel() for one in maps.values()])
    dark, holes = bool(np.any(values < 0)), bool(np.isnan(values).any())
    n_lines = len(classes) + dark
    layout = lay_out(len(maps), *largest, 0.0, FOOTER_IN, least_width=0.0, beside=KEY_IN)
    width = layout.size[0] + KEY_IN
    height = max(layout.size[1], n_lines * LINE_IN + 0.45)
    figure = Figure(figsize=(width, height))
    colours = ListedColormap([NO_SIGNAL, *(class_colour(c) for c in range(len(classes)))])
    for index, (name, one) in enumerate(maps.items()):
        left, bottom, across, up = layout.of_smaller(index, *extent(one))
        panel = place(figure, left, bottom + height - layout.size[1], across, up)
        draw_cells(panel, one, colours, -1.5, len(classes) - 0.5)
        panel.set_title(name, pad=3)
    _key(figure, classes, dark, MARGIN_IN + layout.columns * layout.slot[0] + GAP_IN, height)
    end = scale_bar(figure, MARGIN_IN, MARGIN_IN + 0.06, layout.scale, unit, max(largest[0], 1e-12))
    if holes:
        hole_key(figure, max(end, 0.55) + 0.2, MARGIN_IN + 0.01)
    return figure


def _key(figure: Figure, classes: Classes, dark: bool, left: float, height: float) -> None:
    from matplotlib.patches import Rectangle

    across, up = figure.get_size_inches()
    entries = [(class_colour(c), class_name(classes, c)) for c in range(len(classes))]
    entries += [(NO_SIGNAL, "none: no signal")] if dark else []
    top = height - MARGIN_IN - 0.3
    write(figure, left, top + 0.11, "class (points)", fontsize=SMALL, va="bottom")
    for row, (colour, text) in enumerate(entries):
        y = top - row * LINE_IN
        figure.add_artist(
            Rectangle((left / across, (y - 0.05) / up), 0.1 / across, 0.1 / up, facecolor=colour,
                      edgecolor=INK, linewidth=0.4, transform=figure.transFigure)
        )  # fmt: skip
        write(figure, left + 0.16, y, text, fontsize=SMALL, va="center")
