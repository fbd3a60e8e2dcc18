"""Find a chessboard's inner corners in a picture, and their order on the bench.

The board's columns run along bench x and its rows along bench y. How bench x runs in the picture
is known from the camera's orientation (`x_runs`), since a chessboard has no other left and right:
the square outside the first corner is black, and a mirrored picture looks like a board that is
turned round. What no chessboard reveals is a picture mirrored along the side with an even number
of corners (for 9 x 6, top to bottom): it looks like one from an upside-down camera beyond the board.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...driver import ActionFailed

if TYPE_CHECKING:
    import numpy as np

REFINED_PX = 0.01
MOST_ROUNDS = 40
LEAST_PART = (5, 4)  # corners; fewer turn up in any gravel
RUNS = {"right": (1, 0), "up": (0, -1), "left": (-1, 0), "down": (0, 1)}
"""The directions that bench x may have in a picture: pixels to the right and downwards."""


@dataclass(frozen=True, slots=True)
class Board:
    """A grid of inner corners, one `square_mm` apart; the first one is at bench (x, y, height).

    `angle_deg` is how far its columns are turned from bench x, towards bench y.
    """

    columns: int = 9
    rows: int = 6
    square_mm: float = 25.0
    x_mm: float = 0.0
    y_mm: float = 0.0
    angle_deg: float = 0.0
    height_mm: float = 0.0

    def corners_mm(self) -> "np.ndarray":
        """The corners on the bench, shape (rows, columns, 3)."""
        import numpy as np

        y, x = np.mgrid[: self.rows, : self.columns] * float(self.square_mm)
        return self.to_bench(np.stack([x, y], axis=-1))

    def to_bench(self, own_mm: "np.ndarray") -> "np.ndarray":
        """Points of the board's face, from its first corner, as points of the bench: (..., 2) to (..., 3)."""
        import numpy as np

        angle = np.radians(self.angle_deg)
        cos, sin = np.cos(angle), np.sin(angle)
        x, y = own_mm[..., 0], own_mm[..., 1]
        across, up = self.x_mm + cos * x - sin * y, self.y_mm + sin * x + cos * y
        return np.stack([across, up, np.full_like(across, self.height_mm)], axis=-1)


def find_corners(grey: "np.ndarray", board: Board) -> "np.ndarray":
    """Pixels of the inner corners, shape (rows, columns, 2), from any end; raises ActionFailed."""
    import cv2

    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    found, corners = cv2.findChessboardCornersSB(grey, (board.columns, board.rows), flags=flags)
    if not found:
        raise ActionFailed("BoardNotFound", _why_not(grey, board))
    return _refined(grey, corners.reshape(board.rows, board.columns, 2))


def corners_on_bench(
    grey: "np.ndarray", corners: "np.ndarray", x_runs: str = "right", angle_deg: float = 0.0
) -> "np.ndarray":
    """The corners in the board's own order; raises ActionFailed."""
    ordered = _in_bench_order(corners, _ways(x_runs, angle_deg))
    _check_way(ordered, x_runs, angle_deg)
    _check_first_square(grey, ordered)
    return ordered


def _why_not(grey: "np.ndarray", board: Board) -> str:
    """What is visible of a board that is not completely in the picture."""
    import cv2

    whole = f"no complete chessboard of {board.columns} x {board.rows} inner corners in the picture"
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_LARGER
    found, _, part = cv2.findChessboardCornersSBWithMeta(grey, LEAST_PART, flags)
    if not found:
        return f"{whole}: uncover it, light it evenly, and make sure that the picture is sharp"
    rows, columns = sorted(part.shape[:2], reverse=board.rows > board.columns)
    return (
        f"{whole}, only {columns} x {rows} of one: something covers the rest, it extends beyond the "
        "picture, or the board has another size"
    )


def _refined(grey: "np.ndarray", corners: "np.ndarray") -> "np.ndarray":
    import cv2
    import numpy as np

    closest = min(np.linalg.norm(np.diff(corners, axis=axis), axis=-1).min() for axis in (0, 1))
    half = int(np.clip(closest / 3, 2, 11))  # no other corner may lie in the window
    criteria = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, MOST_ROUNDS, REFINED_PX)
    flat = np.ascontiguousarray(corners.reshape(-1, 1, 2), dtype=np.float32)
    return cv2.cornerSubPix(grey, flat, (half, half), (-1, -1), criteria).reshape(corners.shape)


def _in_bench_order(corners: "np.ndarray", ways: tuple["np.ndarray", "np.ndarray"]) -> "np.ndarray":
    """The order in which columns and rows run the two ways; OpenCV begins anywhere."""
    orders = [corners, corners[::-1], corners[:, ::-1], corners[::-1, ::-1]]
    if corners.shape[0] == corners.shape[1]:
        orders += [order.swapaxes(0, 1) for order in orders]
    along_x, along_y = ways

    def fit(order: "np.ndarray") -> float:
        across, up = _edges(order)
        return float(across @ along_x + up @ along_y)

    return max(orders, key=fit).copy()


def _check_way(corners: "np.ndarray", x_runs: str, angle_deg: float) -> None:
    along_x, along_y = _ways(x_runs, angle_deg)
    across, _ = _edges(corners)
    if abs(across @ along_x) < abs(across @ along_y):
        rows, columns = corners.shape[:2]
        raise ActionFailed(
            "BoardMirrored",
            f"the rows of {columns} corners lie across the direction that bench x should have in the "
            f"picture ({x_runs}): the board or the picture is turned by 90 degrees, or columns and "
            f"rows are swapped and it is a board of {rows} x {columns}",
        )


def _check_first_square(grey: "np.ndarray", corners: "np.ndarray") -> None:
    """Raise ActionFailed if the square outside the first corner is white.

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
            "the square outside the board's first corner is white, so the picture is mirrored, or "
            "the board or the picture is turned round: the black corner square belongs where bench "
            "x and y start",
        )


def _ways(x_runs: str, angle_deg: float) -> tuple["np.ndarray", "np.ndarray"]:
    """The directions of the board's columns and rows in a picture from above.

    Bench y is a quarter turn to the left of bench x.
    """
    import numpy as np

    right, down = RUNS[x_runs]
    x, y = np.array([right, down], float), np.array([down, -right], float)
    cos, sin = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    return cos * x + sin * y, cos * y - sin * x


def _edges(corners: "np.ndarray") -> tuple["np.ndarray", "np.ndarray"]:
    """How far the board's rows reach, and its columns: two pixel vectors."""
    across = (corners[:, -1] - corners[:, 0]).mean(axis=0)
    return across, (corners[-1] - corners[0]).mean(axis=0)


def _grey_at(grey: "np.ndarray", pixel: "np.ndarray") -> float:
    import numpy as np

    height, width = grey.shape
    u, v = np.clip(np.round(pixel).astype(int), 2, (width - 3, height - 3))
    return float(grey[v - 2 : v + 3, u - 2 : u + 3].mean())
