"""What is known about a camera: its one or two lenses, and the board used to measure them."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from .board import Board
from .intrinsics import Intrinsics

if TYPE_CHECKING:
    import numpy as np

SURE_MIDDLE = 0.2  # of the picture's size: the line of sight is never further from its middle


class CameraFault(ValueError):
    """A camera file that cannot be used, with the reason."""


@dataclass(frozen=True, slots=True, eq=False)
class Camera:
    """One eye; or two, where a point X of the left one (mm) is `turn` X + `shift_mm` for the right.

    `rms_px` is the reprojection error that was left when the lens was measured.
    """

    left: Intrinsics
    right: Intrinsics | None = None
    turn: "np.ndarray | None" = None
    shift_mm: "np.ndarray | None" = None
    board: Board | None = None
    rms_px: float | None = None

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of one eye's pictures; 0 if the file does not give them."""
        return self.left.width, self.left.height

    def to_dict(self) -> dict[str, Any]:
        """As plain numbers, as `labrun calibrate-camera` writes them."""
        told: dict[str, Any] = {"width": self.left.width, "height": self.left.height}
        told |= _plain(self.left)
        if self.right is not None and self.turn is not None and self.shift_mm is not None:
            told["right"] = _plain(self.right)
            told["turn"] = self.turn.tolist()
            told["shift"] = self.shift_mm.ravel().tolist()
        if self.board is not None:
            board = self.board
            size = {"columns": board.columns, "rows": board.rows, "square": board.square_mm}
            told["board"] = size
        if self.rms_px is not None:
            told["rms"] = round(self.rms_px, 4)
        return told

    @classmethod
    def from_dict(cls, told: dict[str, Any]) -> "Camera":
        """Read from plain numbers; raises CameraFault, KeyError, TypeError or ValueError."""
        import numpy as np

        width, height = int(told["width"]), int(told["height"])
        left = _eye(width, height, told)
        board = told.get("board")
        kept = (
            Board(int(board["columns"]), int(board["rows"]), float(board["square"]))
            if board
            else None
        )
        rms = None if told.get("rms") is None else float(told["rms"])
        if "right" not in told:
            return cls(left, board=kept, rms_px=rms)
        turn, shift = np.array(told["turn"], float), np.array(told["shift"], float)
        if turn.shape != (3, 3) or shift.shape != (3,):
            raise CameraFault("turn must be 3 x 3 numbers and shift 3 numbers (mm)")
        return cls(left, _eye(width, height, told["right"]), turn, shift, kept, rms)


def of_size(cameras: tuple[Camera, ...], width: int, height: int, path: Path) -> Camera:
    """The one of these cameras that takes pictures of this size; raises CameraFault.

    A file without a size is accepted if its line of sight is near the middle of the picture.
    """
    for camera in cameras:
        if camera.size == (width, height):
            return camera
        if camera.size == (0, 0) and _looks_through_the_middle(camera.left, width, height):
            eyes = (camera.left, camera.right)
            left, right = (e and Intrinsics(width, height, e.matrix, e.distortion) for e in eyes)
            assert left is not None
            return Camera(left, right, camera.turn, camera.shift_mm, camera.board, camera.rms_px)
    known = " and ".join(f"{w} x {h}" for w, h in (c.size for c in cameras) if w)
    raise CameraFault(
        f"{path} is for {f'pictures of {known}' if known else 'another picture size'}, and this "
        f"one is {width} x {height}: calibrate the camera at the size at which it is used"
    )


def _looks_through_the_middle(eye: Intrinsics, width: int, height: int) -> bool:
    u, v = eye.matrix[:2, 2]
    return abs(u / width - 0.5) < SURE_MIDDLE and abs(v / height - 0.5) < SURE_MIDDLE


def _plain(eye: Intrinsics) -> dict[str, Any]:
    return {"matrix": eye.matrix.tolist(), "distortion": eye.distortion.ravel().tolist()}


def _eye(width: int, height: int, told: dict[str, Any]) -> Intrinsics:
    import numpy as np

    matrix = np.array(told["matrix"], float)
    distortion = np.array(told.get("distortion") or [0.0] * 5, float).ravel()
    if (
        matrix.shape != (3, 3)
        or not np.isfinite(matrix).all()
        or min(matrix[0, 0], matrix[1, 1]) <= 0
    ):
        raise CameraFault("the camera matrix must be 3 x 3 numbers, fx and fy above 0")
    if distortion.size not in (4, 5, 8, 12, 14) or not np.isfinite(distortion).all():
        raise CameraFault(
            f"a distortion must have 4, 5, 8, 12 or 14 numbers, not {distortion.size}"
        )
    return Intrinsics(width, height, matrix, distortion)
