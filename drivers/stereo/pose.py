"""Where the left eye is and how it looks, from a chessboard that lies on the bench."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from ..driver import ActionFailed
from .board import Board
from .rig import Rig

if TYPE_CHECKING:
    import numpy as np

POOR_PX = 1.0
"""Corners that lie further than this from where they should (rms) fit no single place."""
SLOPE = 1e-4  # rad and mm: small enough for a slope


@dataclass(frozen=True, slots=True)
class Pose:
    """`turn` takes bench directions to the camera's (right, down, ahead); `place_mm` is on the bench."""

    turn: "np.ndarray"
    place_mm: "np.ndarray"

    @classmethod
    def looking(cls, place_mm: tuple[float, float, float], tilt_deg: float) -> "Pose":
        """Straight down, or tilted towards bench y; bench x is to the right in the picture."""
        import numpy as np

        sin, cos = np.sin(np.radians(tilt_deg)), np.cos(np.radians(tilt_deg))
        return cls(
            np.array([[1, 0, 0], [0, -cos, -sin], [0, sin, -cos]]), np.array(place_mm, float)
        )

    @property
    def tilt_deg(self) -> float:
        """Between the line of sight and straight down."""
        import numpy as np

        return float(np.degrees(np.arccos(np.clip(-self.turn[2, 2], -1, 1))))

    def nudged(self, about_mm: "np.ndarray", turned: "np.ndarray", shifted: "np.ndarray") -> "Pose":
        """The pose after a small turn (rad) of all it sees about a bench point, and a shift (mm)."""
        import cv2

        turn = cv2.Rodrigues(turned)[0] @ self.turn
        shift = self.turn @ (about_mm - self.place_mm) + shifted
        return Pose(turn, about_mm - turn.T @ shift)

    def right_eye(self, rig: Rig) -> "Pose":
        """The pose of the other eye."""
        return Pose(self.turn, self.place_mm + rig.baseline_mm * self.turn[0])

    def project(self, points_mm: "np.ndarray", rig: Rig) -> "np.ndarray":
        """Pixels of bench points, shape (..., 2)."""
        seen = (points_mm - self.place_mm) @ self.turn.T @ rig.matrix().T
        return seen[..., :2] / seen[..., 2:]


@dataclass(frozen=True, slots=True)
class Calibration:
    """A pose, its reprojection error, and how sure it is.

    `covariance` is that of a small turn about `about_mm` and of a shift; about the middle of the
    board the two hardly disturb each other.
    """

    pose: Pose
    rms_px: float
    about_mm: "np.ndarray"
    covariance: "np.ndarray"

    def to_dict(self) -> dict[str, Any]:
        """As plain numbers, to be kept in a file."""
        return {
            "turn": self.pose.turn.tolist(),
            "place_mm": self.pose.place_mm.tolist(),
            "rms_px": self.rms_px,
            "about_mm": self.about_mm.tolist(),
            "covariance": self.covariance.tolist(),
        }

    @classmethod
    def from_dict(cls, kept: dict[str, Any]) -> "Calibration":
        """Back from plain numbers."""
        import numpy as np

        pose = Pose(np.array(kept["turn"]), np.array(kept["place_mm"]))
        covariance = np.array(kept["covariance"])
        return cls(pose, float(kept["rms_px"]), np.array(kept["about_mm"]), covariance)


def fit_pose(corners: "np.ndarray", board: Board, rig: Rig) -> Calibration:
    """The pose from which the board's corners look as they do; raises ActionFailed."""
    import cv2
    import numpy as np

    points, pixels = board.corners_mm().reshape(-1, 3), corners.reshape(-1, 2).astype(float)
    found, turned, shift = cv2.solvePnP(
        points, pixels, rig.matrix(), None, flags=cv2.SOLVEPNP_ITERATIVE
    )
    if not found:
        raise ActionFailed("PoorFit", "the corners fit no place of the camera at all")
    turn = cv2.Rodrigues(turned)[0]
    pose = Pose(turn, -turn.T @ shift.ravel())
    rms = float(np.sqrt(np.mean(np.sum((pose.project(points, rig) - pixels) ** 2, axis=1))))
    if pose.place_mm[2] <= 0:
        raise ActionFailed(
            "BoardMirrored",
            f"the corners put the camera {-pose.place_mm[2]:.0f} mm under the bench: "
            "the picture is mirrored",
        )
    if rms > POOR_PX:
        raise ActionFailed(
            "PoorFit",
            f"the corners lie {rms:.2f} pixel (rms) from where a flat board and a still camera "
            f"would put them; up to {POOR_PX:g} is good: lay the board flat and let nothing shake",
        )
    middle = points.mean(axis=0)
    return Calibration(pose, rms, middle, _covariance(pose, points, middle, rms, rig))


def _covariance(
    pose: Pose, points: "np.ndarray", middle: "np.ndarray", rms_px: float, rig: Rig
) -> "np.ndarray":
    """(J'J)^-1 s^2, J being how the pixels move with each of the pose's six figures."""
    import numpy as np

    here = pose.project(points, rig)
    moved = [pose.nudged(middle, n[:3], n[3:]) for n in np.eye(6) * SLOPE]
    slopes = np.stack([(other.project(points, rig) - here).ravel() for other in moved], 1) / SLOPE
    return np.linalg.inv(slopes.T @ slopes) * rms_px**2 / 2


def check_depth(
    left: "np.ndarray", right: "np.ndarray", board: Board, pose: Pose, rig: Rig
) -> None:
    """Raise ActionFailed where the right eye sees the board's corners on the wrong side.

    In mirrored pictures, and with the eyes exchanged, what is near seems to lie behind the camera.
    """
    shift = float((left - right)[..., 0].mean())
    ahead = (board.corners_mm() - pose.place_mm) @ pose.turn[2]
    wanted = rig.focal_px * rig.baseline_mm / float(ahead.mean())
    if shift <= 0:
        raise ActionFailed(
            "BoardMirrored",
            f"the right eye sees the board {-shift:.0f} pixel to the right of where the left eye "
            "does: the pictures are mirrored, or the eyes are exchanged",
        )
    if abs(shift / wanted - 1) > 0.05:
        raise ActionFailed(
            "PoorFit",
            f"the eyes see the board {shift:.1f} pixel apart, its place asks for {wanted:.1f}: "
            "is the size of its squares right?",
        )
