"""Where on the bench a pixel points, and how certain that is.

The paper's equations, with R and t from the board: a pixel at depth d is K^-1 (u, v, 1) d in front
of the camera, and R^T (that - t) on the bench. The lens distortion is removed first.
"""

from dataclasses import replace
from typing import TYPE_CHECKING

from ...driver import ActionFailed
from .intrinsics import Intrinsics
from .pose import SLOPE, Calibration, Pose

if TYPE_CHECKING:
    import numpy as np

PIXEL = 0.5  # how far the given pixel may be from the intended thing
SURE = 2.8  # standard deviations in space that cover 19 of 20


def point_at_height(
    pose: Pose, eye: Intrinsics, u: float, v: float, height_mm: float
) -> "np.ndarray":
    """Where the line of sight through a pixel meets a level plane: (x, y, z), mm; raises ActionFailed."""
    ray = _ray(pose, eye, u, v)
    drop = height_mm - pose.place_mm[2]
    if drop * ray[2] <= 0:
        raise ActionFailed(
            "OutsidePicture",
            f"pixel {u:g}, {v:g} looks past the bench: nothing {height_mm:g} mm high lies there",
        )
    return pose.place_mm + ray * drop / ray[2]


def point_at_depth(
    pose: Pose, eye: Intrinsics, u: float, v: float, depth_mm: float
) -> "np.ndarray":
    """The bench point at a pixel and depth: (x, y, z), mm."""
    return pose.place_mm + _ray(pose, eye, u, v) * depth_mm


def bench_points(pose: Pose, eye: Intrinsics, depth: "np.ndarray", step: int = 1) -> "np.ndarray":
    """The bench point of every `step`th pixel of a depth map, shape (rows, columns, 3), NaN kept."""
    import numpy as np

    v, u = np.mgrid[: eye.height : step, : eye.width : step]
    rays = eye.rays(np.stack([u, v], axis=-1).astype(float))
    return pose.place_mm + (rays * depth[::step, ::step, None]) @ pose.turn


def uncertainty_mm(
    fit: Calibration,
    eye: Intrinsics,
    u: float,
    v: float,
    height_mm: float | None,
    depth_mm: float,
    depth_sd_mm: float,
) -> float:
    """The radius that contains the true place 19 times out of 20.

    From the pose, from how the board lay, from the pixel and from the depth.

    Errors of the lens parameters are not included.
    """
    import numpy as np

    pose = fit.pose

    def point(pose: Pose, du: float = 0.0, dv: float = 0.0, ahead: float = 0.0) -> "np.ndarray":
        if height_mm is not None:
            return point_at_height(pose, eye, u + du, v + dv, height_mm)
        return point_at_depth(pose, eye, u + du, v + dv, depth_mm + ahead)

    here = point(pose)
    nudges = np.eye(6) * SLOPE
    moved = [point(pose.nudged(fit.about_mm, n[:3], n[3:])) - here for n in nudges]
    slopes = np.array(moved) / SLOPE
    spread = slopes.T @ fit.covariance @ slopes
    for moved in (
        point(pose, du=PIXEL),
        point(pose, dv=PIXEL),
        point(pose, ahead=depth_sd_mm),
    ):
        spread += np.outer(moved - here, moved - here)
    lifted = (
        point(replace(pose, place_mm=pose.place_mm + np.array((0.0, 0.0, fit.lying.z_mm)))) - here
    )
    spread += fit.lying.spread(here) + np.outer(lifted, lifted)
    return float(SURE * np.sqrt(np.linalg.eigvalsh(spread)[-1]))


def _ray(pose: Pose, eye: Intrinsics, u: float, v: float) -> "np.ndarray":
    """Bench direction of a pixel, of length one along the line of sight."""
    import numpy as np

    return pose.turn.T @ eye.rays(np.array([u, v], float))
