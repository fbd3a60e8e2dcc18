"""The answers of a camera, measured in one look: each function answers one question.

A driver calls these in a thread, as they take a processor for a second.
"""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from ...driver import ActionFailed
from .board import Board
from .view import View

if TYPE_CHECKING:
    from collections.abc import Sequence

    import numpy as np

    from .pose import Calibration

TOUCH_SD_MM = 0.2
"""How well a tool's tip is set on a corner by eye."""
TENTH_MM, FARTHEST = 10, 65_535  # depth maps are stored in 0.1 mm
FINEST_MM, ABOVE_CELLS = 0.2, 500_000  # of a picture from above: about a megabyte


def calibrate(
    view: View,
    board: Board,
    touched: "Sequence[dict[str, Any]]" = (),
    touch_sd_mm: float = TOUCH_SD_MM,
) -> "Calibration":
    """Where the eye is, from the board as it lies, or as corners of it were touched; raises ActionFailed."""
    from .pose import fit_pose
    from .touched_points import Lying, as_touched

    board, lying = as_touched(board, touched, touch_sd_mm) if touched else (board, Lying())
    corners = view.corners(board)
    fit = fit_pose(corners, board, view.eye)
    view.check(corners, board, fit.pose)
    return replace(fit, lying=lying)


def locate(
    view: View, fit: "Calibration", u: float, v: float, height_mm: float | None
) -> dict[str, float]:
    """Where the thing at one pixel is, by its known height or by depth; raises ActionFailed."""
    import numpy as np

    from .depth import depth_around
    from .pixel_position import point_at_depth, point_at_height, uncertainty_mm

    eye = view.eye
    if not eye.holds(u, v):
        size = f"{eye.width} x {eye.height}"
        raise ActionFailed("OutsidePicture", f"pixel {u:g}, {v:g} is not in a picture of {size}")
    if height_mm is not None:
        point = point_at_height(fit.pose, eye, u, v, height_mm)
        ahead, off = float((point - fit.pose.place_mm) @ fit.pose.turn[2]), 0.0
    else:
        ahead, spread = depth_around(view.depth, u, v)
        off = view.depth_sd_mm(ahead, spread)
        point = point_at_depth(fit.pose, eye, u, v, ahead)
    around = uncertainty_mm(fit, eye, u, v, height_mm, ahead, off)
    x, y, z = np.round(point, 3).tolist()
    return {"x": x, "y": y, "z": z, "uncertainty": round(around, 3)}


def outlines(
    view: View, fit: "Calibration", min_height_mm: float, min_area_mm2: float, flat: bool
) -> list[dict[str, Any]]:
    """The things on the bench; `flat`: also those that do not stand out from it. Raises ActionFailed."""
    from .samples import find_samples

    return find_samples(view, fit, min_height_mm, min_area_mm2, flat)


def picture_file(view: View, name: str) -> bytes:
    """The picture: PNG, or JPEG under such a name."""
    if name.lower().endswith((".jpg", ".jpeg")):
        return _encoded(view.picture, ".jpg", "JPEG")
    return _encoded(view.picture)


def above_file(view: View, fit: "Calibration", name: str) -> tuple[bytes, dict[str, Any]]:
    """The bench from straight above, and its size and edges in mm; raises ActionFailed.

    What the camera does not see is transparent in a PNG and black in a JPEG.
    """
    import numpy as np

    from .plan import plan_of

    plan = plan_of(view.picture, fit.pose, view.eye, FINEST_MM, ABOVE_CELLS)
    if plan is None:
        raise ActionFailed(
            "OutsidePicture", "no part of the bench up to 2 m away is in the picture"
        )
    jpeg = name.lower().endswith((".jpg", ".jpeg"))
    colours = np.where(plan.seen[..., None], plan.picture, 0).astype(np.uint8)
    full = np.where(plan.seen, 255, 0).astype(np.uint8)
    cells = colours if jpeg else np.dstack([colours, full])
    data = _encoded(cells[::-1], *((".jpg", "JPEG") if jpeg else (".png", "PNG")))
    rows, columns = plan.seen.shape
    left, front = plan.corner_mm.tolist()
    right, back = left + columns * plan.cell_mm, front + rows * plan.cell_mm
    edges = {"left": left, "right": right, "front": front, "back": back}
    place = {edge: round(mm, 3) for edge, mm in edges.items()}
    return data, {"width": columns, "height": rows, **place}


def depth_png(view: View) -> bytes:
    """The depth map in 0.1 mm, 16 bit, 0 where unknown or 6.55 m away; raises ActionFailed."""
    import numpy as np

    depth = np.nan_to_num(view.depth * TENTH_MM)
    return _encoded(np.where(depth < FARTHEST, np.round(depth), 0).astype(np.uint16))


def _encoded(picture: "np.ndarray", suffix: str = ".png", kind: str = "PNG") -> bytes:
    import cv2

    done, data = cv2.imencode(suffix, picture)
    if not done:
        raise ActionFailed("CameraLost", f"the picture could not be written as {kind}")
    return data.tobytes()
