"""Draw element maps side by side, as a paper would print them."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from math import ceil
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from .maps import ElementMap
from .spectrum import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = "viridis"  # perceptually uniform, and readable in grey and by the colour-blind
HOLE_COLOUR = "#b9b9b9"
DOTS_PER_INCH = 200
MOST_WIDTH_IN = 12.0  # of all panels beside each other
PANEL_HEIGHT_IN, PANEL_WIDTH_IN = 4.4, 3.4  # the most that one map takes
NARROWEST_PANEL_IN = 0.9  # room for its title
AROUND_IN = (1.5, 1.0)  # labels, colour bar and title
BETWEEN_IN = (0.15, 0.6)
SCALE_BAR_PART = 0.4  # the most of a map's width that the scale bar takes
TICK_STEPS = (1, 2, 5, 10)
ROUND_LENGTHS = (1.0, 2.0, 5.0)


def draw_element_maps(
    maps: Mapping[str, ElementMap], path: Path, title: str = "", unit: str = "mm"
) -> Path:
    """Draw one panel a map, each from its smallest value (0) to its largest (1), into a file.

    maps: panel title -> map, all of one sample, coordinates in `unit`. The format is that of the
    path's suffix (.png, .svg, .pdf). Gives the path back. Raises ValueError without a map.
    """
    if not maps:
        raise ValueError("there is no map to draw")
    figure = element_maps_figure(maps, title, unit)
    figure.savefig(path, dpi=DOTS_PER_INCH, facecolor="white", bbox_inches="tight", pad_inches=0.1)
    return path


def element_maps_figure(
    maps: Mapping[str, ElementMap], title: str = "", unit: str = "mm"
) -> Figure:
    """The figure itself, for those who want to draw more into it."""
    matplotlib = _quiet_matplotlib()
    from matplotlib.figure import Figure

    width, height = _panel_size(next(iter(maps.values())))
    n_rows = ceil(len(maps) * (width + BETWEEN_IN[0]) / MOST_WIDTH_IN)
    n_columns = ceil(len(maps) / n_rows)
    figure = Figure(
        figsize=(
            n_columns * width + (n_columns - 1) * BETWEEN_IN[0] + AROUND_IN[0],
            n_rows * height + (n_rows - 1) * BETWEEN_IN[1] + AROUND_IN[1],
        ),
        layout="constrained",
    )
    grid = figure.subplots(n_rows, n_columns, sharex=True, sharey=True, squeeze=False)
    colours = matplotlib.colormaps[COLOURS].with_extremes(bad=HOLE_COLOUR)
    panels = list(grid.flat)
    mesh = None
    for panel, (name, element_map) in zip(panels, maps.items(), strict=False):
        mesh = panel.pcolormesh(
            _edges(element_map.x),
            _edges(element_map.y),
            np.ma.masked_invalid(element_map.normalised().values),
            cmap=colours,
            vmin=0.0,
            vmax=1.0,
            rasterized=True,
        )
        _dress(panel, name, element_map)
    for spare, above in zip(panels[len(maps) :], panels[len(maps) - n_columns :], strict=False):
        spare.set_visible(False)
        above.tick_params(labelbottom=True)
    _scale_bar(panels[0], unit)
    figure.supxlabel(f"x ({unit})", fontsize=9)
    figure.supylabel(f"y ({unit})", fontsize=9)
    figure.get_layout_engine().set(w_pad=0.03, h_pad=0.04)  # pyright: ignore
    if title:
        figure.suptitle(title, fontsize=11)
    if mesh is not None:
        bar = figure.colorbar(mesh, ax=grid, fraction=0.05, pad=0.02, aspect=30)
        bar.set_label("value, from the map's lowest (0) to its highest (1); grey: none", fontsize=8)
        bar.ax.tick_params(labelsize=8)
        bar.outline.set_linewidth(0.6)  # pyright: ignore[reportCallIssue]
    return figure


def _quiet_matplotlib():
    """matplotlib, without its remark on a home folder that it cannot keep its font list in."""
    log = logging.getLogger("matplotlib")
    level = log.level
    log.setLevel(logging.ERROR)
    try:
        import matplotlib
        import matplotlib.font_manager
    finally:
        log.setLevel(level)
    return matplotlib


def _panel_size(element_map: ElementMap) -> tuple[float, float]:
    """Width and height in inches of a panel that shows the map undistorted."""
    x, y = _edges(element_map.x), _edges(element_map.y)
    across, up = x[-1] - x[0], y[-1] - y[0]
    scale = min(PANEL_WIDTH_IN / across, PANEL_HEIGHT_IN / up)
    return max(across * scale, NARROWEST_PANEL_IN), max(up * scale, NARROWEST_PANEL_IN)


def _edges(centres: FloatArray) -> FloatArray:
    """Where the cells around the centres begin and end; shape (n + 1,)."""
    if len(centres) == 1:
        return centres[0] + np.array([-0.5, 0.5])
    between = 0.5 * (centres[1:] + centres[:-1])
    return np.concatenate(([2 * centres[0] - between[0]], between, [2 * centres[-1] - between[-1]]))


def _dress(panel: Axes, name: str, element_map: ElementMap) -> None:
    from matplotlib.ticker import MaxNLocator

    known = element_map.values[np.isfinite(element_map.values)]
    panel.set_title(name, fontsize=11, fontweight="bold", pad=15)
    if len(known):
        panel.annotate(
            f"{_short(known.min())} to {_short(known.max())}",
            (0.5, 1.0),
            xytext=(0, 4),
            xycoords="axes fraction",
            textcoords="offset points",
            ha="center",
            fontsize=7,
            color="#444444",
        )
    panel.set_aspect("equal")
    panel.set_facecolor(HOLE_COLOUR)
    panel.xaxis.set_major_locator(MaxNLocator(nbins=5, steps=TICK_STEPS))
    panel.yaxis.set_major_locator(MaxNLocator(nbins=6, steps=TICK_STEPS))
    panel.tick_params(labelsize=8, direction="out", length=2.5, width=0.6)
    for spine in panel.spines.values():
        spine.set_linewidth(0.6)


def _short(value: float) -> str:
    return f"{value:,.0f}" if abs(value) >= 100 else f"{value:.3g}"


def _scale_bar(panel: Axes, unit: str) -> None:
    """A bar of a round length in the lower left corner, with its length over it."""
    from matplotlib.patheffects import withStroke

    (left, right), (bottom, top) = panel.get_xlim(), panel.get_ylim()
    length = round_length(SCALE_BAR_PART * (right - left))
    x, y = left + 0.08 * (right - left), bottom + 0.04 * (top - bottom)
    outline = [withStroke(linewidth=4.5, foreground="black")]
    panel.plot(
        [x, x + length],
        [y, y],
        color="white",
        linewidth=2.5,
        solid_capstyle="butt",
        path_effects=outline,
    )
    panel.annotate(
        f"{length:g} {unit}",
        (x + length / 2, y),
        xytext=(0, 4),
        textcoords="offset points",
        ha="center",
        va="bottom",
        fontsize=8,
        color="white",
        path_effects=[withStroke(linewidth=1.8, foreground="black")],
    )


def round_length(most: float) -> float:
    """The longest of ... 0.5, 1, 2, 5, 10 ... that is no longer than `most` (above 0)."""
    decade = 10.0 ** np.floor(np.log10(most))
    return float(max(step * decade for step in ROUND_LENGTHS if step * decade <= most * (1 + 1e-9)))
