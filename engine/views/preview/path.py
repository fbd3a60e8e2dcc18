"""One device's path: coloured by its order, or by its loops; start, end, and what is outside."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .walk import Path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.cm import ScalarMappable

COLOURS = "viridis"  # perceptually uniform, and readable in grey and by the colour-blind
BY_TRACK = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#8c6bb1", "#7f7f7f")
OUTSIDE = "#d62728"
BETWEEN = "#a8a8a8"
"""For the path from one loop to the next."""
FEW = 60
"""Up to this many points, every step of the path gets its own arrow."""
ARROWS = 24
SHORTEST_ARROW = 0.015
"""As a part of the whole extent: heads on shorter parts would overlap."""


def draw_path(axes: Axes, path: Path) -> ScalarMappable | None:
    """Draw it; returns the colour scale if the colour is the order, None if it is the loop."""
    import numpy as np

    xy = np.array([(point.x_mm, point.y_mm) for point in path.points])
    by_order = len(path.tracks) == 1 and len(xy) > 2
    scale = _lines(axes, path, xy, by_order)
    _dots(axes, path, xy, by_order)
    _arrows(axes, path, xy)
    _ends(axes, xy)
    outside = path.outside
    if outside:
        size = _size(len(xy)) * 1.4
        axes.scatter(*xy[outside].T, s=size, c=OUTSIDE, zorder=5, lw=0, label="outside")
    return scale


def _size(count: int) -> float:
    """The area of a dot, in points squared: smaller for many points."""
    return max(1.0, min(16.0, 4000.0 / count))


def _lines(axes: Axes, path: Path, xy: Any, by_order: bool) -> ScalarMappable | None:
    from matplotlib.collections import LineCollection

    joined = [i for i, point in enumerate(path.points) if point.joined]
    segments = [xy[i - 1 : i + 1] for i in joined]
    width = 1.2 if len(xy) < 2000 else 0.6
    if not by_order:
        tracks = [point.track for point in path.points]
        own = [tracks[i] == tracks[i - 1] for i in joined]
        colours = [
            _colour(tracks[i]) if mine else BETWEEN for i, mine in zip(joined, own, strict=True)
        ]
        widths = [width if mine else 0.7 for mine in own]
        axes.add_collection(LineCollection(segments, colors=colours, lw=widths, zorder=2))
        return None
    lines = LineCollection(segments, cmap=COLOURS, lw=width, zorder=2)
    lines.set_array(joined)
    lines.set_clim(1, len(xy))
    axes.add_collection(lines)
    return lines


def _colour(track: int) -> str:
    return BY_TRACK[track % len(BY_TRACK)]


def _dots(axes: Axes, path: Path, xy: Any, by_order: bool) -> None:
    size = _size(len(xy))
    if by_order:
        axes.scatter(*xy.T, s=size, c=range(1, len(xy) + 1), cmap=COLOURS, lw=0, zorder=3)
        return
    for track, name in enumerate(path.tracks):
        mine = [i for i, point in enumerate(path.points) if point.track == track]
        label = name if name not in ("steps", "finally") else f"single steps ({name})"
        axes.scatter(*xy[mine].T, s=size, c=_colour(track), lw=0, zorder=3, label=label)


def _arrows(axes: Axes, path: Path, xy: Any) -> None:
    """Heads in the middle of some parts of the path, to show its direction."""
    joined = [i for i, point in enumerate(path.points) if point.joined]
    shortest = SHORTEST_ARROW * (xy.max(axis=0) - xy.min(axis=0)).max()
    steps = [i for i in joined if abs(xy[i] - xy[i - 1]).max() > shortest]
    if not steps or len(xy) > 2000:
        return
    every = 1 if len(steps) <= FEW else len(steps) // ARROWS
    for i in steps[every // 2 :: every]:
        middle, way = (xy[i] + xy[i - 1]) / 2, (xy[i] - xy[i - 1]) * 0.01
        axes.annotate(
            "", xytext=tuple(middle - way), xy=tuple(middle + way), zorder=4,
            arrowprops={"arrowstyle": "-|>", "color": "#333333", "lw": 0.6, "mutation_scale": 6},
        )  # fmt: skip


def _ends(axes: Axes, xy: Any) -> None:
    """A circle where it starts, a square where it ends."""
    for place, marker, label, below in ((xy[0], "o", "start", -13), (xy[-1], "s", "end", 5)):
        left = place[0] > xy[:, 0].mean()
        axes.plot(
            *place, marker=marker, ms=6.5, mfc="white", mec="black", mew=1.1, ls="", zorder=6,
            label=label, clip_on=False,
        )  # fmt: skip
        axes.annotate(
            label, place, textcoords="offset points", xytext=(-6 if left else 6, below),
            ha="right" if left else "left", fontsize=7.5, zorder=7,
            bbox={"boxstyle": "round,pad=0.12", "fc": "white", "ec": "none", "alpha": 0.8},
        )  # fmt: skip
