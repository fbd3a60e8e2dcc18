"""The bench seen from straight above, computed from a picture taken at an angle."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

from .board import Board
from .intrinsics import Intrinsics
from .pose import Pose

if TYPE_CHECKING:
    import numpy as np

FARTHEST_MM = 2000.0
MOST_CELLS = 4_000_000
RIM = 1.0  # of a square: how far a printed board may extend beyond its squares
LIKE_A_BOARD = 0.7  # correlation of the picture with black and white squares


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Square cells of the bench, z = 0; the first row is the front one, the first column the left.

    `corner_mm` is the left front corner of the first cell. `picture` has the colours, `seen` marks
    the cells that the camera sees.
    """

    corner_mm: "np.ndarray"
    cell_mm: float
    picture: "np.ndarray"
    seen: "np.ndarray"

    def centres_mm(self) -> tuple["np.ndarray", "np.ndarray"]:
        """Bench x and y of every cell's middle, each of the shape of the plan."""
        import numpy as np

        rows, columns = np.mgrid[: self.seen.shape[0], : self.seen.shape[1]] + 0.5
        x, y = self.corner_mm
        return x + columns * self.cell_mm, y + rows * self.cell_mm

    def cells(self, points_mm: "np.ndarray") -> "np.ndarray":
        """Column and row, fractional, of bench points (..., 2 or 3): 0.5 is the middle of the first."""
        return (points_mm[..., :2] - self.corner_mm) / self.cell_mm


def plan_of(
    picture: "np.ndarray", pose: Pose, eye: Intrinsics, cell_mm: float = 1.0,
    most_cells: int = MOST_CELLS,
) -> Plan | None:  # fmt: skip
    """The part of the bench that a picture shows, up to 2 m away; None if it shows none."""
    import cv2
    import numpy as np

    area = _area_mm(pose, eye)
    if area is None:
        return None
    low, high = area
    cell_mm = max(cell_mm, float(np.sqrt(np.prod(high - low) / most_cells)))
    columns, rows = np.maximum(np.ceil((high - low) / cell_mm).astype(int), 1)
    empty = np.zeros((rows, columns), bool)
    x, y = Plan(low, cell_mm, picture, empty).centres_mm()
    points = np.stack([x, y, np.zeros_like(x)], axis=-1)
    ahead = (points - pose.place_mm) @ pose.turn[2]
    pixels = pose.project(points, eye).astype(np.float32)
    u, v = pixels[..., 0], pixels[..., 1]
    seen = (ahead > 0) & (u >= 0) & (v >= 0) & (u <= eye.width - 1) & (v <= eye.height - 1)
    above = cv2.remap(_calmed(picture, pose, eye, cell_mm), u, v, cv2.INTER_LINEAR)
    return Plan(low, cell_mm, above, seen)


def board_cells(plan: Plan, board: Board) -> "np.ndarray":
    """The cells that a board covers, including its rim; none if the board is no longer there."""
    import cv2
    import numpy as np

    covered = np.zeros(plan.seen.shape, np.uint8)
    if _looks_like(plan, board):
        edge = (1 + RIM) * board.square_mm
        right = (board.columns - 1) * board.square_mm + edge
        back = (board.rows - 1) * board.square_mm + edge
        own = np.array([[-edge, -edge], [right, -edge], [right, back], [-edge, back]])
        corners = board.to_bench(own)[:, :2]
        cv2.fillConvexPoly(covered, np.round(plan.cells(corners)).astype(np.int32), 1)
    return covered.astype(bool)


def _looks_like(plan: Plan, board: Board) -> bool:
    """Whether the middles of the inner squares alternate between black and white."""
    import numpy as np

    corners = board.corners_mm()[..., :2]
    middles = (corners[:-1, :-1] + corners[1:, 1:]) / 2
    columns, rows = np.floor(plan.cells(middles)).astype(int).reshape(-1, 2).T
    height, width = plan.seen.shape
    inside = (columns >= 0) & (rows >= 0) & (columns < width) & (rows < height)
    if inside.mean() < 0.5:
        return False
    black = (np.indices(middles.shape[:2]).sum(axis=0) % 2 == 0).ravel()[inside]
    grey = plan.picture[rows[inside], columns[inside]].mean(axis=-1)
    if grey.std() < 1:
        return False
    return bool(np.corrcoef(grey, black)[0, 1] < -LIKE_A_BOARD)


def _area_mm(pose: Pose, eye: Intrinsics) -> tuple["np.ndarray", "np.ndarray"] | None:
    """The smallest and the largest bench x and y that are in the picture and near enough."""
    import numpy as np

    u = np.linspace(0, eye.width - 1, 33)
    v = np.linspace(0, eye.height - 1, 33)
    rays = eye.rays(np.stack(np.meshgrid(u, v), axis=-1)) @ pose.turn
    down = rays[..., 2] < -1e-6
    far = np.where(down, -pose.place_mm[2] / np.where(down, rays[..., 2], -1), np.inf)
    near = far <= FARTHEST_MM
    if not near.any():
        return None
    points = pose.place_mm + rays[near] * far[near, None]
    return points[:, :2].min(axis=0), points[:, :2].max(axis=0)


def _calmed(picture: "np.ndarray", pose: Pose, eye: Intrinsics, cell_mm: float) -> "np.ndarray":
    """The picture without detail finer than a cell, which would only flicker."""
    import cv2

    ahead = max(abs(pose.place_mm[2] / pose.turn[2, 2]), 1.0) if pose.turn[2, 2] else FARTHEST_MM
    pixels = eye.focal_px * cell_mm / ahead
    return cv2.GaussianBlur(picture, (0, 0), pixels / 2) if pixels > 1.5 else picture
