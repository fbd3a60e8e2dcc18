"""The figure: the path in order over the work area, as a paper would print it."""

from __future__ import annotations

import logging
import textwrap
from pathlib import Path as File
from typing import TYPE_CHECKING, Any

from ..english import count_of, joined
from .overview import draw_overview, is_small
from .path import OUTSIDE, draw_path
from .plane import Area
from .walk import Path, Walk

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FORMATS = (".png", ".svg", ".pdf")
DOTS_PER_INCH = 200
WIDTH_IN, TALLEST_IN, FLATTEST_IN = 7.0, 5.4, 2.0
MAIN_PART = 0.66
"""As a part of the width; beside it are the colour scale or legend, and the overview."""
ROOM_IN = 3.0
MARGIN = 0.06
TABLE = "#e9e9e9"
STYLE: Any = {
    "font.size": 9, "font.family": "DejaVu Sans", "axes.linewidth": 0.7, "axes.titlesize": 10,
    "xtick.direction": "out", "ytick.direction": "out", "xtick.major.width": 0.7,
    "ytick.major.width": 0.7, "legend.frameon": False, "svg.fonttype": "none", "pdf.fonttype": 42,
}  # fmt: skip


def draw(walk: Walk, name: str, file: File) -> None:
    """Draw every device's path into a file, in the format of its suffix."""
    logging.getLogger("matplotlib").setLevel(logging.WARNING)
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        figure = preview_figure(walk, name)
        figure.savefig(
            file, dpi=DOTS_PER_INCH, facecolor="white", bbox_inches="tight", pad_inches=0.12,
            metadata=_metadata(file, name),
        )  # fmt: skip


def _metadata(file: File, name: str) -> dict[str, Any]:
    """The title, and no date: the same protocol gives the same file."""
    if file.suffix == ".png":
        return {"Title": f"Preview of {name}"}
    date = {"Date": None} if file.suffix == ".svg" else {"CreationDate": None}
    return {"Title": f"Preview of {name}", **date}


def preview_figure(walk: Walk, name: str) -> Figure:
    """The figure, one row of panels per device that moves."""
    from matplotlib.figure import Figure

    paths = [path for path in walk.paths.values() if path.points]
    heights = [_height(_view(path)) for path in paths]
    notes = _notes(walk)
    foot, head, between = 0.15 + 0.17 * len(notes), 0.22, 1.0
    total = head + sum(heights) + between * len(paths) + foot
    figure = Figure(figsize=(WIDTH_IN, total))
    left = 0.62 / WIDTH_IN
    figure.text(left, 1 - 0.12 / total, _plain(name), fontsize=11, weight="bold", va="top")
    top = total - head
    for path, height in zip(paths, heights, strict=True):
        bottom = top - 0.5 - height
        box = (left, bottom / total, MAIN_PART - 0.1, height / total)
        _panels(figure, path, box, len(paths) > 1)
        top = bottom - (between - 0.5)
    for index, line in enumerate(reversed(notes)):
        figure.text(left, (0.1 + 0.17 * index) / total, line, fontsize=7.5, color="#444444")
    return figure


def _panels(
    figure: Figure, path: Path, box: tuple[float, float, float, float], named: bool
) -> None:
    from matplotlib.ticker import MaxNLocator

    _, bottom, _, height = box
    axes = figure.add_axes(box, anchor="NW")
    view = _view(path)
    _bench(axes, path)
    scale = draw_path(axes, path)
    axes.set(xlim=view.x, ylim=view.y, xlabel="x (mm)", ylabel="y (mm)")
    axes.set_aspect("equal", adjustable="box")
    axes.set_title(_title(path, named), loc="left", pad=19 if _second(path) else 6)
    colour = OUTSIDE if path.outside else "#444444"
    axes.annotate(
        _plain(_second(path)), (0, 1), xycoords="axes fraction", xytext=(0, 6),
        textcoords="offset points", fontsize=8, color=colour,
    )  # fmt: skip
    axes.apply_aspect()
    right = axes.get_position().x1 + 0.035
    if scale is not None and _has_room(view, path):
        bar = figure.add_axes((right, bottom, 0.018, height * 0.55), anchor="SW")
        figure.colorbar(
            scale, cax=bar, label="order of the points", ticks=MaxNLocator(6, integer=True)
        )
    elif scale is None:
        handles, labels = axes.get_legend_handles_labels()
        labels = [textwrap.fill(label, 30) for label in labels]
        figure.legend(
            handles, labels, loc="lower left", bbox_to_anchor=(right - 0.015, bottom), fontsize=7.5
        )
    if is_small(view, path.plane.area):
        right += 0.035  # space for its numbers
        side = min(0.26, 0.97 - right)
        tall = min(height * 0.36, side * figure.get_figwidth() / figure.get_figheight())
        where = figure.add_axes((right, bottom + height - tall, side, tall), anchor="NW")
        draw_overview(where, path, view)


def _bench(axes: Axes, path: Path) -> None:
    """White where the device may go, grey elsewhere; the contract's edge if it differs."""
    from matplotlib.patches import Rectangle

    area = path.plane.area
    if not area.bounded:
        return
    axes.set_facecolor(TABLE)
    (left, right), (front, back) = area.x, area.y
    size = (right - left, back - front)
    axes.add_patch(Rectangle((left, front), *size, fc="white", ec="#555555", lw=1.0, zorder=0))
    allowed = path.plane.allowed
    if allowed.bounded and allowed != area:
        corner, size = (allowed.x[0], allowed.y[0]), tuple(b - a for a, b in (allowed.x, allowed.y))
        axes.add_patch(Rectangle(corner, *size, fc="none", ec="#999999", lw=0.8, ls="--", zorder=0))


def _view(path: Path) -> Area:
    """What the main panel shows: the points with a margin, or the whole area if they fill it."""
    points = path.points
    columns = [one.x_mm for one in points], [one.y_mm for one in points]
    edges = [(min(values), max(values)) for values in columns]
    longest = max(high - low for low, high in edges)
    margin = MARGIN * longest if longest > 0 else 10.0
    spread = []
    for low, high in edges:
        # A single row of points still gets a visible panel.
        missing = max(0.0, longest * 0.4 - (high - low)) / 2
        spread.append((low - margin - missing, high + margin + missing))
    seen = Area(spread[0], spread[1])
    area = path.plane.area
    if not area.bounded or is_small(seen, area):
        return seen
    room = MARGIN * max(area.x[1] - area.x[0], area.y[1] - area.y[0])
    (xs, ys), (ax, ay) = (seen.x, seen.y), (area.x, area.y)
    return Area(
        (min(xs[0], ax[0] - room), max(xs[1], ax[1] + room)),
        (min(ys[0], ay[0] - room), max(ys[1], ay[1] + room)),
    )


def _height(view: Area) -> float:
    """Inches of a panel, so that both axes have the same scale."""
    ratio = (view.y[1] - view.y[0]) / (view.x[1] - view.x[0])
    return min(TALLEST_IN, max(FLATTEST_IN, (MAIN_PART - 0.1) * WIDTH_IN * ratio))


def _title(path: Path, named: bool) -> str:
    """How many points, and how far it is from the first to the last."""
    far = path.length_mm
    length = f"{far:,.1f} mm" if far < 1000 else f"{far / 1000:,.2f} m"
    who = f"{path.plane.device}: " if named else ""
    return f"{who}{count_of(len(path.points), 'point')}, path {length}"


def _second(path: Path) -> str:
    """How many points are outside, or how the points are laid out if one loop makes them all."""
    outside = len(path.outside)
    if outside:
        return f"{outside:,} outside {path.plane.area} (red)"
    if len(path.tracks) > 1:
        return ""
    if not _has_room(_view(path), path) and len(path.points) > 2:
        return "from dark to bright in the order of the points"
    return path.tracks[0] if ":" in path.tracks[0] else ""


def _has_room(view: Area, path: Path) -> bool:
    """True if a colour scale fits beside the panel, under the overview."""
    return _height(view) >= ROOM_IN or not is_small(view, path.plane.area)


def _notes(walk: Walk) -> list[str]:
    """What a reader must know about what is drawn and what is not."""
    drawn = [path for path in walk.paths.values() if path.points and path.plane.area.bounded]
    areas = {str(one.plane.area): [] for one in drawn}
    for one in drawn:
        areas[str(one.plane.area)].append(one.plane.device)
    notes = [f"White: where {joined(who)} may go, {area}." for area, who in areas.items()]
    notes += walk.notes
    if walk.full:
        drawn = sum(len(path.points) for path in walk.paths.values())
        notes.append(f"Only the first {count_of(drawn, 'point')} are drawn; there are more.")
    for path in walk.paths.values():
        if path.unknown:
            places = count_of(path.unknown, "place")
            notes.append(f"{path.plane.device}: {places} known only during the run are not drawn.")
    return [line for note in notes for line in textwrap.wrap(_plain(note), 110)]


def _plain(text: str) -> str:
    """A literal dollar sign, not the start of a formula."""
    return text.replace("$", r"\$")
