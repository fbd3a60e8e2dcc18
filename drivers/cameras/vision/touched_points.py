"""How a board lies on the bench, from corners that the gantry's tool has touched.

Two points give the place and the angle: 0.3 degrees are 2 mm at the far end of a wide bench. Their
distance is known from the squares, so a wrong corner or a wrong square shows. The rigid motion is that of
least squares (Kabsch 1976, doi:10.1107/S0567739476001873), in the plane.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from ...driver import ActionFailed
from .board import Board

if TYPE_CHECKING:
    import numpy as np

OFF_MM = 1.0
"""Touched points further (rms) from the board's corners than this are others, or badly read."""
UNLEVEL_MM, UNLEVEL_SD = 0.5, 5.0
"""Heights of one level face lie within this, or within so many errors of a touch."""
THICKNESS_SD_MM = 0.05
"""Of a thickness that was measured with a calliper and given as a number."""


@dataclass(frozen=True, slots=True)
class Lying:
    """How well it is known how a board lies: one standard deviation of each.

    The angle's error (rad) turns everything about `middle_mm`.
    """

    middle_mm: tuple[float, float] = (0.0, 0.0)
    xy_mm: float = 0.0
    angle: float = 0.0
    z_mm: float = 0.0

    def spread(self, point: "np.ndarray") -> "np.ndarray":
        """The covariance that this gives to a bench point, mm2, without that of the height."""
        import numpy as np

        dx, dy = point[0] - self.middle_mm[0], point[1] - self.middle_mm[1]
        turned = self.angle * np.array([-dy, dx, 0.0])
        return np.diag([self.xy_mm**2, self.xy_mm**2, 0.0]) + np.outer(turned, turned)


def as_touched(
    board: Board, touched: Sequence[dict[str, Any]], touch_sd_mm: float
) -> tuple[Board, Lying]:
    """The board as it lies, and how well that is known; raises ActionFailed.

    Each of `touched` is `{column, row, x, y}`, with `z` where the height was read too; columns and
    rows count from 0 at the board's first inner corner.
    """
    import numpy as np

    places = [(int(one["column"]), int(one["row"])) for one in touched]
    _check_corners(board, places)
    own = np.array(places, float) * board.square_mm
    there = np.array([(one["x"], one["y"]) for one in touched], float)
    p, q = own - own.mean(axis=0), there - there.mean(axis=0)
    angle = float(np.arctan2(np.sum(p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]), np.sum(p * q)))
    cos, sin = np.cos(angle), np.sin(angle)
    off = q - p @ np.array([[cos, sin], [-sin, cos]])
    rms = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
    if rms > OFF_MM:
        ratio = float(np.linalg.norm(q) / np.linalg.norm(p))
        raise ActionFailed(
            "PoorFit",
            f"the touched points are {rms:.1f} mm (rms) from where the board's corners would be, and "
            f"{abs(ratio - 1):.1%} {'wider' if ratio > 1 else 'closer'} together: is a square "
            f"{board.square_mm:g} mm, and were these inner corners touched, counted from 0?",
        )
    x, y = there.mean(axis=0) - np.array([[cos, -sin], [sin, cos]]) @ own.mean(axis=0)
    height, z_sd = _height(board, touched, touch_sd_mm)
    freedom = max(1, 2 * len(touched) - 3)
    sd = max(touch_sd_mm, float(np.sqrt(np.sum(off**2) / freedom)) if len(touched) > 2 else 0.0)
    lying = Lying(
        (float(there[:, 0].mean()), float(there[:, 1].mean())),
        sd / len(touched) ** 0.5, sd / float(np.linalg.norm(p)), z_sd,
    )  # fmt: skip
    angle_deg = float(np.degrees(angle))
    return replace(
        board, x_mm=float(x), y_mm=float(y), angle_deg=angle_deg, height_mm=height
    ), lying


def _check_corners(board: Board, places: Sequence[tuple[int, int]]) -> None:
    if len(set(places)) < 2:
        raise ActionFailed("PoorFit", "touch two different corners of the board, far apart")
    for column, row in places:
        if column >= board.columns or row >= board.rows:
            raise ActionFailed(
                "PoorFit",
                f"the board has no inner corner at column {column}, row {row}: columns are 0 to "
                f"{board.columns - 1}, rows 0 to {board.rows - 1}",
            )


def _height(
    board: Board, touched: Sequence[dict[str, Any]], touch_sd_mm: float
) -> tuple[float, float]:
    """The height of the board's face, and its standard deviation."""
    heights = [float(one["z"]) for one in touched if one.get("z") is not None]
    if not heights:
        return board.height_mm, THICKNESS_SD_MM if board.height_mm else 0.0
    if max(heights) - min(heights) > max(UNLEVEL_MM, UNLEVEL_SD * touch_sd_mm):
        raise ActionFailed(
            "PoorFit",
            f"the board is not level: it was touched from z {min(heights):.2f} to {max(heights):.2f} mm; "
            "lay it flat, or touch it again",
        )
    return sum(heights) / len(heights), touch_sd_mm / len(heights) ** 0.5
