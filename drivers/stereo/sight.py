"""Where on the bench a pixel points, and how sure that is."""

from typing import TYPE_CHECKING

from .pose import SLOPE, Calibration, Pose
from .rig import Rig

if TYPE_CHECKING:
    import numpy as np

PIXEL = 0.5  # how far the named pixel may be from the thing that is meant
DISPARITY_PX = 0.25  # how far the two eyes' agreement may be off
SURE = 2.8  # standard deviations in space that hold 19 of 20


def point_at_height(pose: Pose, rig: Rig, u: float, v: float, height_mm: float) -> "np.ndarray":
    """Where the line of sight through a pixel meets a level plane: (x, y, z), mm."""
    ray = _ray(pose, rig, u, v)
    return pose.place_mm + ray * (height_mm - pose.place_mm[2]) / ray[2]


def point_at_depth(pose: Pose, rig: Rig, u: float, v: float, depth_mm: float) -> "np.ndarray":
    """What lies so far ahead of the camera at a pixel: (x, y, z), mm."""
    return pose.place_mm + _ray(pose, rig, u, v) * depth_mm


def points_of(pose: Pose, rig: Rig, depth: "np.ndarray", step: int = 2) -> "np.ndarray":
    """The bench points of every `step`th pixel of a depth map, those without depth left out."""
    import numpy as np

    v, u = np.mgrid[: rig.height : step, : rig.width : step].reshape(2, -1)
    ahead = depth[v, u]
    known = np.isfinite(ahead)
    middle_u, middle_v = rig.middle
    right, down = (u[known] - middle_u) / rig.focal_px, (v[known] - middle_v) / rig.focal_px
    rays = np.stack([right, down, np.ones_like(right)], axis=-1)
    return pose.place_mm + (rays * ahead[known, None]) @ pose.turn


def uncertainty_mm(
    fit: Calibration, rig: Rig, u: float, v: float, height_mm: float | None, depth_mm: float
) -> float:
    """The radius that holds the true place 19 times of 20: of the pose, the pixel and the depth."""
    import numpy as np

    pose = fit.pose

    def point(pose: Pose, du: float = 0.0, dv: float = 0.0, ahead: float = 0.0) -> "np.ndarray":
        if height_mm is not None:
            return point_at_height(pose, rig, u + du, v + dv, height_mm)
        return point_at_depth(pose, rig, u + du, v + dv, depth_mm + ahead)

    here = point(pose)
    nudges = np.eye(6) * SLOPE
    moved = [point(pose.nudged(fit.about_mm, n[:3], n[3:])) - here for n in nudges]
    slopes = np.array(moved) / SLOPE
    spread = slopes.T @ fit.covariance @ slopes
    ahead = DISPARITY_PX * depth_mm**2 / (rig.focal_px * rig.baseline_mm)
    for moved in (point(pose, du=PIXEL), point(pose, dv=PIXEL), point(pose, ahead=ahead)):
        spread += np.outer(moved - here, moved - here)
    return float(SURE * np.sqrt(np.linalg.eigvalsh(spread)[-1]))


def _ray(pose: Pose, rig: Rig, u: float, v: float) -> "np.ndarray":
    """Bench direction of a pixel, one long along the line of sight."""
    import numpy as np

    middle_u, middle_v = rig.middle
    ahead = np.array([(u - middle_u) / rig.focal_px, (v - middle_v) / rig.focal_px, 1.0])
    return pose.turn.T @ ahead
