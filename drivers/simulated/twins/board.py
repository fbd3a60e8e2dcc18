"""A printed chessboard as an eye sees it: every pixel an average of what lies within it."""

from typing import TYPE_CHECKING

from ...cameras.vision.board import Board

if TYPE_CHECKING:
    import numpy as np

BLACK, WHITE = 28.0, 226.0
FINE = 4  # places across a pixel
RIM = 0.6  # of a square: the white around the outermost squares


def plate_mm(board: Board) -> "np.ndarray":
    """The four corners of the printed plate on the bench, shape (4, 3)."""
    import numpy as np

    edge = board.square_mm * (1 + RIM)
    right = board.x_mm + (board.columns - 1) * board.square_mm + edge
    back = board.y_mm + (board.rows - 1) * board.square_mm + edge
    left, front = board.x_mm - edge, board.y_mm - edge
    return np.array([[left, front, 0], [right, front, 0], [right, back, 0], [left, back, 0.0]])


def print_onto(picture: "np.ndarray", board: Board, to_pixel: "np.ndarray") -> None:
    """Draw the board into a picture; `to_pixel` takes (x, y, 1) on the bench to (u, v, 1) w."""
    import numpy as np

    height, width = picture.shape[:2]
    corners = plate_mm(board) * (1, 1, 0) + (0, 0, 1)
    seen = corners @ to_pixel.T
    seen = seen[:, :2] / seen[:, 2:]
    left, top = np.clip(np.floor(seen.min(axis=0)).astype(int), 0, (width, height))
    right, bottom = np.clip(np.ceil(seen.max(axis=0)).astype(int) + 1, 0, (width, height))
    if right <= left or bottom <= top:
        return
    inside = (np.arange(FINE) + 0.5) / FINE - 0.5
    u = (np.arange(left, right)[:, None] + inside).ravel()
    v = (np.arange(top, bottom)[:, None] + inside).ravel()
    shade, on_plate = _shade(board, u, v, np.linalg.inv(to_pixel))
    area = (bottom - top, FINE, right - left, FINE)
    share = on_plate.reshape(area).mean(axis=(1, 3))[..., None]
    shade = shade.reshape(area).mean(axis=(1, 3))[..., None]
    part = picture[top:bottom, left:right]
    part[:] = np.where(share > 0, part * (1 - share) + shade, part).astype(picture.dtype)


def _shade(
    board: Board, u: "np.ndarray", v: "np.ndarray", to_bench: "np.ndarray"
) -> tuple["np.ndarray", "np.ndarray"]:
    """Grey of the board at each of the places (0 beside it), and whether it is the board."""
    import numpy as np

    rows, columns = v[:, None].astype(np.float32), u[None].astype(np.float32)
    m = to_bench.astype(np.float32)
    weight = m[2, 0] * columns + m[2, 1] * rows + m[2, 2]
    x = ((m[0, 0] * columns + m[0, 1] * rows + m[0, 2]) / weight - board.x_mm) / board.square_mm
    y = ((m[1, 0] * columns + m[1, 1] * rows + m[1, 2]) / weight - board.y_mm) / board.square_mm
    printed = (x >= -1) & (x < board.columns) & (y >= -1) & (y < board.rows)
    on_plate = (x >= -1 - RIM) & (x < board.columns + RIM)
    on_plate &= (y >= -1 - RIM) & (y < board.rows + RIM)
    black = printed & ((np.floor(x).astype(np.int32) + np.floor(y).astype(np.int32)) % 2 == 0)
    return np.where(black, np.float32(BLACK), np.float32(WHITE)) * on_plate, on_plate
