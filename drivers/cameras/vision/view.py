"""One look of a camera: the picture, the eye that took it, and the depth on request."""

import math
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from ...driver import ActionFailed
from .board import Board, corners_on_bench, find_corners
from .camera import Camera, CameraFault, of_size
from .intrinsics import Intrinsics
from .rig import Rig, rectification, rectified

if TYPE_CHECKING:
    import numpy as np

    from .pose import Pose

DISPARITY_PX = 0.25  # error of the match between two eyes
OFF = 0.05  # of the distance: a larger error means that a given size or unit is wrong
INDEPENDENT = 3.0  # neighbouring depths have similar errors: a window's median gains only this much
SCALE_SD = 0.001  # of the distance: the scale error of a depth camera


class View:
    """A picture as OpenCV holds it (8 bit, blue first), without depth."""

    def __init__(self, picture: "np.ndarray", eye: Intrinsics, x_runs: str = "right") -> None:
        _check_size(picture, eye)
        self.picture, self.eye, self.x_runs = picture, eye, x_runs

    @cached_property
    def grey(self) -> "np.ndarray":
        """The picture without its colours."""
        return _grey(self.picture)

    @cached_property
    def depth(self) -> "np.ndarray":
        """Depth in mm at every pixel, NaN where unknown; raises ActionFailed."""
        raise ActionFailed(
            "NoDepth",
            "this camera sees no depth: give the height of the thing, or a depth map",
        )

    def depth_sd_mm(self, ahead_mm: float, spread_mm: float) -> float:
        """The error of a window's median whose single pixels are off by `spread_mm`."""
        return float((spread_mm / INDEPENDENT) ** 2 + (SCALE_SD * ahead_mm) ** 2) ** 0.5

    def corners(self, board: Board) -> "np.ndarray":
        """The board's corners in bench order; raises ActionFailed."""
        return corners_on_bench(
            self.grey, find_corners(self.grey, board), self.x_runs, board.angle_deg
        )

    def check(self, corners: "np.ndarray", board: Board, pose: "Pose") -> None:
        """Raise ActionFailed if the known depth contradicts a pose."""


class DepthView(View):
    """A picture and the depth map that came with it, pixel by pixel.

    `reach_mm`, where two eyes measured it: their focal length (pixels) times the distance between them.
    """

    def __init__(
        self, picture: "np.ndarray", depth: "np.ndarray", eye: Intrinsics, x_runs: str = "right",
        reach_mm: float | None = None,
    ) -> None:  # fmt: skip
        super().__init__(picture, eye, x_runs)
        if depth.shape != picture.shape[:2]:
            height, width = depth.shape[:2]
            raise ActionFailed(
                "NoDepth",
                f"the depth map is {width} x {height}, and the picture is {eye.width} x "
                f"{eye.height}: they must match pixel by pixel",
            )
        self._depth, self._reach_mm = depth, reach_mm

    def depth_sd_mm(self, ahead_mm: float, spread_mm: float) -> float:
        """The match between the eyes is the same for the whole window, so its median does not gain."""
        matched = DISPARITY_PX * ahead_mm**2 / self._reach_mm if self._reach_mm else 0.0
        return math.hypot(super().depth_sd_mm(ahead_mm, spread_mm), matched)

    @cached_property
    def depth(self) -> "np.ndarray":
        import numpy as np

        known = np.isfinite(self._depth) & (self._depth > 0)
        if not known.any():
            raise ActionFailed(
                "NoDepth", "the depth map contains no depth: all values are NaN or 0"
            )
        return np.where(known, self._depth, np.nan).astype(np.float32)

    def check(self, corners: "np.ndarray", board: Board, pose: "Pose") -> None:
        import numpy as np

        rows, columns = np.round(corners[..., ::-1].reshape(-1, 2)).astype(int).T
        known = np.isfinite(self._depth) & (self._depth > 0)
        seen = known[rows, columns]
        if not seen.any():
            return  # the board may be too near or too dark for depth: its place is known anyway
        ahead = (board.corners_mm().reshape(-1, 3) - pose.place_mm) @ pose.turn[2]
        ratio = float(np.median(self._depth[rows, columns][seen] / ahead[seen]))
        if abs(ratio - 1) > OFF:
            raise ActionFailed(
                "PoorFit",
                f"the depth map puts the board {ratio * ahead.mean():.0f} mm away, its squares "
                f"{ahead.mean():.0f} mm: are the square size and the depth unit right?",
            )


class StereoView(View):
    """Two rectified pictures of a rig; depth comes from their disparity."""

    def __init__(
        self, left: "np.ndarray", right: "np.ndarray", rig: Rig, x_runs: str = "right"
    ) -> None:
        super().__init__(left, rig.eye, x_runs)
        _check_size(right, rig.eye)
        self.right, self.rig = right, rig

    @classmethod
    def of(
        cls, left: "np.ndarray", right: "np.ndarray", camera: Camera, x_runs: str = "right"
    ) -> "StereoView":
        """From two pictures as the eyes of a camera took them; raises ActionFailed."""
        _check_size(left, camera.left)
        _check_size(right, camera.left)
        rig, left_maps, right_maps = rectification(camera)
        return cls(rectified(left, left_maps), rectified(right, right_maps), rig, x_runs)

    @cached_property
    def depth(self) -> "np.ndarray":
        from .depth import depth_map

        return depth_map(self.grey, _grey(self.right), self.rig)

    def depth_sd_mm(self, ahead_mm: float, spread_mm: float) -> float:
        return DISPARITY_PX * ahead_mm**2 / self.rig.reach_mm

    def check(self, corners: "np.ndarray", board: Board, pose: "Pose") -> None:
        """In mirrored pictures, and with the eyes swapped, near things seem to lie behind."""
        grey = _grey(self.right)
        others = corners_on_bench(grey, find_corners(grey, board), self.x_runs, board.angle_deg)
        shift = float((corners - others)[..., 0].mean())
        ahead = (board.corners_mm() - pose.place_mm) @ pose.turn[2]
        wanted = self.rig.reach_mm / float(ahead.mean())
        if shift <= 0:
            raise ActionFailed(
                "BoardMirrored",
                f"the right eye sees the board {-shift:.0f} pixels to the right of where the left "
                "eye does: the pictures are mirrored, or the eyes are swapped",
            )
        if abs(shift / wanted - 1) > OFF:
            raise ActionFailed(
                "PoorFit",
                f"the eyes see the board {shift:.1f} pixels apart, its place requires {wanted:.1f}: "
                "is the size of its squares right?",
            )


def view_of(
    picture: "np.ndarray", cameras: tuple[Camera, ...], file: Path, x_runs: str = "right",
    *, right: "np.ndarray | None" = None, depth: "np.ndarray | None" = None,
) -> tuple[View, Camera]:  # fmt: skip
    """What pictures show, by the one of a file's cameras that takes them; raises CameraFault, ActionFailed.

    A picture twice as wide as an eye's, without a depth map of its size, holds both eyes side by side.
    """
    rows, half = picture.shape[0], picture.shape[1] // 2
    alone = right is None and (depth is None or depth.shape != picture.shape[:2])
    if alone and any(one.right is not None and one.size == (half, rows) for one in cameras):
        picture, right = picture[:, :half], picture[:, half:]
    camera = of_size(cameras, picture.shape[1], rows, file)
    if right is not None:
        if camera.right is None:
            raise CameraFault(f"{file} describes one eye, but there are two pictures")
        return StereoView.of(picture, right, camera, x_runs), camera
    if depth is not None:
        return DepthView(picture, depth, camera.left, x_runs), camera
    return View(picture, camera.left, x_runs), camera


def _check_size(picture: "np.ndarray", eye: Intrinsics) -> None:
    height, width = picture.shape[:2]
    if (width, height) != (eye.width, eye.height):
        raise ActionFailed(
            "CameraLost",
            f"the picture is {width} x {height}, and the lens is known for pictures of "
            f"{eye.width} x {eye.height}",
        )


def _grey(picture: "np.ndarray") -> "np.ndarray":
    import cv2

    return picture if picture.ndim == 2 else cv2.cvtColor(picture, cv2.COLOR_BGR2GRAY)
