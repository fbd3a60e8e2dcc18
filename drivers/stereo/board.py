"""Find a chessboard's inner corners in a picture, in the order in which they lie on the bench.

The board's columns run along bench x and its rows along bench y; in the picture, bench x points
rather to the right and bench y rather up. The square outside the first corner is a black one: by
that a mirrored picture is told from a true one, since a chessboard has no other left and right.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..driver import ActionFailed

if TYPE_CHECKING:
    import numpy as np

REFINED_PX = 0.01
MOST_ROUNDS = 40


@dataclass(frozen=True, slots=True)
class Board:
    """So many inner corners, one `square_mm` apart; the first one lies at bench (x, y, 0)."""

    columns: int = 9
    rows: int = 6
    square_mm: float = 25.0
    x_mm: float = 0.0
    y_mm: float = 0.0

    def corners_mm(self) -> "np.ndarray":
        """The corners on the bench, shape (rows, columns, 3)."""
        import numpy as np

        y, x = np.mgrid[: self.rows, : self.columns] * float(self.square_mm)
        return np.stack([self.x_mm + x, self.y_mm + y, np.zeros_like(x)], axis=-1)


def find_corners(grey: "np.ndarray", board: Board) -> "np.ndarray":
    """Pixels of the inner corners, shape (rows, columns, 2); raises ActionFailed."""
    import cv2

    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    found, corners = cv2.findChessboardCornersSB(grey, (board.columns, board.rows), flags=flags)
    if not found:
        raise ActionFailed(
            "BoardNotFound",
            f"no whole chessboard of {board.columns} x {board.rows} inner corners in the picture: "
            "uncover it, light it evenly, and see that the picture is sharp",
        )
    refined = _refined(grey, corners.reshape(board.rows, board.columns, 2))
    return _in_bench_order(refined)


def check_first_square(grey: "np.ndarray", corners: "np.ndarray") -> None:
    """Raise ActionFailed where the square outside the first corner is white.

    A board whose columns and rows are both even or both odd looks the same from both sides.
    """
    rows, columns = corners.shape[:2]
    if (rows + columns) % 2 == 0:
        return
    across, up = corners[0, 1] - corners[0, 0], corners[1, 0] - corners[0, 0]
    outside = _grey_at(grey, corners[0, 0] - (across + up) / 2)
    beside = _grey_at(grey, corners[0, 0] + (across - up) / 2)
    if outside > beside:
        raise ActionFailed(
            "BoardMirrored",
            "the square outside the board's first corner is white, so the picture is mirrored or "
            "the board is turned round: the black corner square belongs to the lower left",
        )


def _refined(grey: "np.ndarray", corners: "np.ndarray") -> "np.ndarray":
    import cv2
    import numpy as np

    closest = min(np.linalg.norm(np.diff(corners, axis=axis), axis=-1).min() for axis in (0, 1))
    half = int(np.clip(closest / 3, 2, 11))  # no other corner may lie in the window
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, MOST_ROUNDS, REFINED_PX)
    flat = np.ascontiguousarray(corners.reshape(-1, 1, 2), dtype=np.float32)
    return cv2.cornerSubPix(grey, flat, (half, half), (-1, -1), criteria).reshape(corners.shape)


def _in_bench_order(corners: "np.ndarray") -> "np.ndarray":
    """The order in which columns run to the right and rows upwards; OpenCV begins anywhere."""
    orders = [corners, corners[::-1], corners[:, ::-1], corners[::-1, ::-1]]
    if corners.shape[0] == corners.shape[1]:
        orders += [order.swapaxes(0, 1) for order in orders]

    def fit(order: "np.ndarray") -> float:
        return (order[:, -1, 0] - order[:, 0, 0]).sum() - (order[-1, :, 1] - order[0, :, 1]).sum()

    return max(orders, key=fit).copy()


def _grey_at(grey: "np.ndarray", pixel: "np.ndarray") -> float:
    import numpy as np

    height, width = grey.shape
    u, v = np.clip(np.round(pixel).astype(int), 2, (width - 3, height - 3))
    return float(grey[v - 2 : v + 3, u - 2 : u + 3].mean())
