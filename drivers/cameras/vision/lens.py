"""Measure a lens from pictures of a chessboard, and report how well each picture fits.

The model is OpenCV's (Zhang 2000, doi:10.1109/34.888718, with Brown's distortion): f, the middle,
k1, k2, p1, p2; k3 only if it differs significantly from zero.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ...driver import ActionFailed
from .board import Board, find_corners
from .camera import Camera
from .intrinsics import Intrinsics

if TYPE_CHECKING:
    import numpy as np

LEAST = 5  # pictures with a board
ALIKE = 0.02  # of the focal length; a larger uncertainty means that all boards were held alike
SHORTEST, LONGEST = 0.2, 8.0  # plausible focal lengths, in picture widths
POOR_PX = 1.0
ODD_ONE = 3.0  # times the usual error: the picture is reported
TOLD = 3.0  # standard deviations


class LensFault(ValueError):
    """Pictures from which no lens can be measured, with the reason."""


@dataclass(frozen=True, slots=True)
class LensFit:
    """A camera and how well it fits: the error (rms, pixels) of each picture, and what was left out.

    `focal_sd_px` is one standard deviation; `covered` the share of the picture's 4 x 4 fields in
    which a corner was seen; `odd` are pictures that fit much worse than the others.
    """

    camera: Camera
    rms_px: float
    errors_px: dict[str, float]
    left_out: dict[str, str]
    focal_sd_px: float
    covered: float
    odd: tuple[str, ...]


def fit_lens(
    pictures: Mapping[str, "np.ndarray"],
    board: Board,
    tell: Callable[[str], None] = lambda name: None,
) -> LensFit:
    """The lens that took these grey pictures, all of one size; raises LensFault.

    A picture that does not show the complete board is left out, with the reason. `tell` is called
    with the name of each picture before it is searched.
    """
    return _fit(pictures, board, tell)[0]


def fit_pair(
    pairs: Mapping[str, tuple["np.ndarray", "np.ndarray"]],
    board: Board,
    tell: Callable[[str], None] = lambda name: None,
) -> LensFit:
    """Two lenses and their relative position, from pictures taken together; raises LensFault."""
    import cv2

    left, seen = _fit({name: pair[0] for name, pair in pairs.items()}, board, tell)
    right, others = _fit({name: pairs[name][1] for name in seen}, board, tell)
    # Both eyes have to start at the same end of the board; OpenCV starts at either.
    pixels = [
        (_column(seen[name]), _column(_alike(one, seen[name]))) for name, one in others.items()
    ]
    points = [_flat_points(board)] * len(pixels)
    eyes = left.camera.left, right.camera.left
    rms, *_, turn, shift, _, _ = cv2.stereoCalibrate(
        points, [pair[0] for pair in pixels], [pair[1] for pair in pixels],
        eyes[0].matrix.copy(), eyes[0].distortion.copy(),
        eyes[1].matrix.copy(), eyes[1].distortion.copy(),
        (eyes[0].width, eyes[0].height), flags=cv2.CALIB_FIX_INTRINSIC,
    )  # fmt: skip
    if rms > POOR_PX:
        raise LensFault(
            f"the two eyes fit together only to {rms:.2f} pixels (rms), up to {POOR_PX:g} is good: "
            "were both pictures of a pair taken at the same time, and are left and right correct?"
        )
    camera = Camera(*eyes, turn, shift.ravel(), board, rms)
    left_out = {
        **left.left_out,
        **{name: f"right eye: {why}" for name, why in right.left_out.items()},
    }
    errors = {name: max(left.errors_px[name], error) for name, error in right.errors_px.items()}
    odd = tuple(dict.fromkeys((*left.odd, *right.odd)))
    sd = max(left.focal_sd_px, right.focal_sd_px)
    return LensFit(camera, rms, errors, left_out, sd, min(left.covered, right.covered), odd)


def _fit(
    pictures: Mapping[str, "np.ndarray"], board: Board, tell: Callable[[str], None]
) -> tuple[LensFit, dict[str, "np.ndarray"]]:
    """The lens, and the corners used to measure it."""
    corners, left_out = _find_boards(pictures, board, tell)
    _check_enough(corners, left_out, board)
    height, width = next(iter(pictures.values())).shape[:2]
    rms, matrix, distortion, sd, errors = _fitted(list(corners.values()), board, (width, height))
    errors_px = dict(zip(corners, errors, strict=True))
    _check(rms, matrix, sd, (width, height))
    camera = Camera(Intrinsics(width, height, matrix, distortion), board=board, rms_px=rms)
    usual = sorted(errors)[len(errors) // 2]
    odd = tuple(name for name, error in errors_px.items() if error > max(ODD_ONE * usual, 0.3))
    covered = _covered(list(corners.values()), width, height)
    return LensFit(camera, rms, errors_px, left_out, sd, covered, odd), corners


def _find_boards(
    pictures: Mapping[str, "np.ndarray"], board: Board, tell: Callable[[str], None]
) -> tuple[dict[str, "np.ndarray"], dict[str, str]]:
    """Corners of each picture that shows the complete board, and why the others do not."""
    corners: dict[str, np.ndarray] = {}
    left_out: dict[str, str] = {}
    for name, grey in pictures.items():
        tell(name)
        try:
            corners[name] = find_corners(grey, board)
        except ActionFailed as failure:
            left_out[name] = failure.message
    return corners, left_out


def _check_enough(corners: Mapping[str, object], left_out: Mapping[str, str], board: Board) -> None:
    """Raise LensFault if too few pictures show the board."""
    if len(corners) >= LEAST:
        return
    size = f"{board.columns} x {board.rows}"
    if not corners:
        why = next(iter(left_out.values()), "there is no picture")
        raise LensFault(
            f"none of {len(left_out)} pictures shows a complete board of {size} inner corners ({why}); "
            "count inner corners, one less than squares"
        )
    raise LensFault(
        f"only {len(corners)} of {len(corners) + len(left_out)} pictures show the complete board of "
        f"{size} inner corners, and a lens needs {LEAST} or more: take 10 to 20 with the board tilted "
        "differently, near and far, in every corner of the picture"
    )


def _fitted(
    corners: list["np.ndarray"], board: Board, size: tuple[int, int]
) -> tuple[float, "np.ndarray", "np.ndarray", float, list[float]]:
    """rms, K, distortion, standard deviation of f, and the error of each picture."""
    import cv2
    import numpy as np

    points, pixels = [_flat_points(board)] * len(corners), [_column(one) for one in corners]
    found = None
    for flags in (0, cv2.CALIB_FIX_K3):
        try:
            found = cv2.calibrateCameraExtended(
                points, pixels, size, np.eye(3), np.zeros(5), flags=flags
            )
        except cv2.error as fault:
            raise LensFault(f"the boards do not fit any lens ({fault.err})") from fault
        k3, k3_sd = float(np.ravel(found[2])[4]), float(np.ravel(found[5])[8])
        if k3_sd and abs(k3) > TOLD * k3_sd:
            break
    assert found is not None
    rms, matrix, distortion, _, _, spread, _, errors = found
    sd = float(max(np.ravel(spread)[:2]))
    return float(rms), matrix, np.ravel(distortion), sd, np.ravel(errors).tolist()


def _check(rms: float, matrix: "np.ndarray", sd: float, size: tuple[int, int]) -> None:
    width, height = size
    focal = float(min(matrix[0, 0], matrix[1, 1]))
    u, v = matrix[:2, 2]
    alike = "hold the board at 20 to 45 degrees, tilted to a different side each time"
    likely = SHORTEST * width < focal < LONGEST * width
    if not likely or not sd < ALIKE * focal:
        raise LensFault(
            f"the focal length is uncertain ({focal:.0f} pixels, give or take {sd:.0f}): {alike}"
        )
    if not (0 < u < width and 0 < v < height):
        raise LensFault(f"the line of sight falls outside the picture ({u:.0f}, {v:.0f}): {alike}")
    if rms > POOR_PX:
        raise LensFault(
            f"the corners fit no lens better than {rms:.2f} pixels (rms), up to {POOR_PX:g} is good: is the "
            "board flat, are the pictures sharp, and all from one camera at one zoom and focus?"
        )


def _covered(corners: list["np.ndarray"], width: int, height: int) -> float:
    import numpy as np

    pixels = np.concatenate([one.reshape(-1, 2) for one in corners])
    fields = np.clip((pixels / (width, height) * 4).astype(int), 0, 3)
    return len(np.unique(fields, axis=0)) / 16


def _alike(corners: "np.ndarray", others: "np.ndarray") -> "np.ndarray":
    """The corners in the one of four orders that matches the others."""
    import numpy as np

    orders = [corners, corners[::-1], corners[:, ::-1], corners[::-1, ::-1]]
    shape = others - others.mean(axis=(0, 1))
    return min(orders, key=lambda one: float(np.abs(one - one.mean(axis=(0, 1)) - shape).sum()))


def _flat_points(board: Board) -> "np.ndarray":
    import numpy as np

    return (board.corners_mm().reshape(-1, 3)).astype(np.float32)


def _column(corners: "np.ndarray") -> "np.ndarray":
    import numpy as np

    return np.ascontiguousarray(corners.reshape(-1, 1, 2), np.float32)
