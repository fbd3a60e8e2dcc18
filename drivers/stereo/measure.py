"""What a stereo camera answers, measured in a pair of pictures: each function is one question.

The pictures are as OpenCV holds them, 8 bit, blue first. A driver calls these in a thread.
"""

from typing import TYPE_CHECKING, Any

from ..driver import ActionFailed
from .board import Board, check_first_square, find_corners
from .rig import Rig

if TYPE_CHECKING:
    import numpy as np

    from .pose import Calibration

    Pair = tuple[np.ndarray, np.ndarray]

TENTH_MM = 10  # depth maps are kept in 0.1 mm


def calibrate(pair: "Pair", board: Board, rig: Rig) -> "Calibration":
    """Where the left eye is, by the board; raises ActionFailed."""
    from .pose import check_depth, fit_pose

    left, right = _greys(pair)
    corners = find_corners(left, board)
    check_first_square(left, corners)
    fit = fit_pose(corners, board, rig)
    check_depth(corners, find_corners(right, board), board, fit.pose, rig)
    return fit


def locate(
    pair: "Pair", fit: "Calibration", rig: Rig, u: float, v: float, height_mm: float | None
) -> dict[str, Any]:
    """Where the thing at one pixel is, by its known height or by depth; raises ActionFailed."""
    import numpy as np

    from .depth import depth_around, depth_map
    from .sight import point_at_depth, point_at_height, uncertainty_mm

    if height_mm is not None:
        point = point_at_height(fit.pose, rig, u, v, height_mm)
        ahead = float((point - fit.pose.place_mm) @ fit.pose.turn[2])
    else:
        ahead = depth_around(depth_map(*_greys(pair), rig), u, v)
        point = point_at_depth(fit.pose, rig, u, v, ahead)
    around = uncertainty_mm(fit, rig, u, v, height_mm, ahead)
    x, y, z = np.round(point, 3).tolist()
    return {"x": x, "y": y, "z": z, "uncertainty": round(around, 3)}


def outlines(
    pair: "Pair", fit: "Calibration", rig: Rig, min_height_mm: float, min_area_mm2: float
) -> list[dict[str, Any]]:
    """What stands out from the bench; raises ActionFailed."""
    from .depth import depth_map
    from .samples import find_samples
    from .sight import points_of

    points = points_of(fit.pose, rig, depth_map(*_greys(pair), rig))
    return find_samples(points, min_height_mm, min_area_mm2)


def picture_png(pair: "Pair") -> bytes:
    """The left eye's picture."""
    return _png(pair[0])


def depth_png(pair: "Pair", rig: Rig) -> bytes:
    """The depth map in 0.1 mm, 16 bit, 0 where unknown; raises ActionFailed."""
    import numpy as np

    from .depth import depth_map

    depth = np.nan_to_num(depth_map(*_greys(pair), rig) * TENTH_MM)
    return _png(np.clip(np.round(depth), 0, 65_535).astype(np.uint16))


def _greys(pair: "Pair") -> "Pair":
    import cv2

    left, right = (cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY) for picture in pair)
    return left, right


def _png(picture: "np.ndarray") -> bytes:
    import cv2

    done, data = cv2.imencode(".png", picture)
    if not done:
        raise ActionFailed("CameraLost", "the picture could not be written as PNG")
    return data.tobytes()
