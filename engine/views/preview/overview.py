"""Where on the bench a small scan is: the whole work area, with the enlarged part."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from .plane import Area
from .walk import Path

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.patches import Rectangle

SMALL = 0.35
"""Of the work area's width and height: a scan smaller than both is enlarged, with an overview."""
SPECK = 0.03
MARK = "#d62728"


def is_small(view: Area, area: Area) -> bool:
    """True if a view is a small part of the work area both ways."""
    if not area.bounded:
        return False
    parts = ((view.x, area.x), (view.y, area.y))
    return all(seen[1] - seen[0] < SMALL * (whole[1] - whole[0]) for seen, whole in parts)


def draw_overview(axes: Axes, path: Path, view: Area) -> None:
    """Draw the work area with a frame, or a ring if a frame would be too small to see."""
    area = path.plane.area
    axes.set_facecolor("white")
    axes.set(xlim=_with(area.x, view.x), ylim=_with(area.y, view.y))
    axes.set_aspect("equal", adjustable="box")
    axes.add_patch(_rectangle(area, fc="white", ec="#555555", lw=0.8))
    if all(b - a < SPECK * (d - c) for (a, b), (c, d) in ((view.x, area.x), (view.y, area.y))):
        centre = (sum(view.x) / 2, sum(view.y) / 2)
        axes.plot(*centre, "o", ms=7, mfc="none", mec=MARK, mew=1.2, clip_on=False, zorder=3)
    else:
        frame = _rectangle(view, fc="none", ec=MARK, lw=1.2)
        frame.set_clip_on(False)
        axes.add_patch(frame)
    axes.set_xticks(area.x)
    axes.set_yticks(area.y)
    axes.tick_params(labelsize=7, length=2.5)
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_title("on the bench (mm)", fontsize=7.5, loc="left", pad=4)


def _rectangle(area: Area, **look: Any) -> Rectangle:
    from matplotlib.patches import Rectangle

    (left, right), (front, back) = area.x, area.y
    return Rectangle((left, front), right - left, back - front, **look)


def _with(whole: tuple[float, float], part: tuple[float, float]) -> tuple[float, float]:
    room = 0.02 * (whole[1] - whole[0])
    return min(whole[0], part[0]) - room, max(whole[1], part[1]) + room
