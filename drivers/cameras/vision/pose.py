"""Position and orientation of an eye, from a chessboard on the bench."""

from dataclasses import astuple, dataclass, field
from typing import TYPE_CHECKING, Any

from ...driver import ActionFailed
from .board import Board
from .intrinsics import Intrinsics
from .touched_points import Lying

if TYPE_CHECKING:
    import numpy as np

POOR_PX = 1.0
"""Corners further than this (rms) from where they should be do not fit a single place."""
STEEP_DEG = 65.0
"""Between the line of sight and the board's normal; beyond it, corners are not accurate enough."""
AS_GOOD, ELSEWHERE = 1.1, 0.02
"""Two places fit alike: the ratio of their errors, and how far apart they are (of the distance)."""
SURE_PX = 0.05  # no corner is more accurate, however well the others fit
SLOPE = 1e-4  # rad and mm: step for a numerical derivative


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
        """Angle between the line of sight and straight down."""
        import numpy as np

        return float(np.degrees(np.arccos(np.clip(-self.turn[2, 2], -1, 1))))

    def nudged(self, about_mm: "np.ndarray", turned: "np.ndarray", shifted: "np.ndarray") -> "Pose":
        """The pose after a small turn (rad) of the scene about a bench point, and a shift (mm)."""
        import cv2

        turn = cv2.Rodrigues(turned)[0] @ self.turn
        shift = self.turn @ (about_mm - self.place_mm) + shifted
        return Pose(turn, about_mm - turn.T @ shift)

    def beside(self, baseline_mm: float) -> "Pose":
        """The pose of an eye this far to the right."""
        return Pose(self.turn, self.place_mm + baseline_mm * self.turn[0])

    def project(self, points_mm: "np.ndarray", eye: Intrinsics) -> "np.ndarray":
        """Pixels of bench points, shape (..., 3) to (..., 2)."""
        return eye.pixels((points_mm - self.place_mm) @ self.turn.T)


@dataclass(frozen=True, slots=True)
class Calibration:
    """A pose, its reprojection error, its covariance, and the board it was found from.

    `covariance` is that of a small turn about `about_mm` and of a shift; about the middle of the
    board the two hardly disturb each other. `lying` is how well it is known how the board lies.
    """

    pose: Pose
    rms_px: float
    about_mm: "np.ndarray"
    covariance: "np.ndarray"
    board: Board
    lying: Lying = field(default_factory=Lying)

    def to_dict(self) -> dict[str, Any]:
        """As plain numbers, to be stored in a file."""
        board = self.board
        return {
            "turn": self.pose.turn.tolist(),
            "place_mm": self.pose.place_mm.tolist(),
            "rms_px": self.rms_px,
            "about_mm": self.about_mm.tolist(),
            "covariance": self.covariance.tolist(),
            "board": list(astuple(board)),
            "lying": list(astuple(self.lying)),
        }

    @classmethod
    def from_dict(cls, kept: dict[str, Any]) -> "Calibration":
        """Read from plain numbers."""
        import numpy as np

        pose = Pose(np.array(kept["turn"]), np.array(kept["place_mm"]))
        about, covariance = np.array(kept["about_mm"]), np.array(kept["covariance"])
        middle, *rest = kept.get("lying") or astuple(Lying())
        lying = Lying((middle[0], middle[1]), *rest)
        return cls(pose, float(kept["rms_px"]), about, covariance, Board(*kept["board"]), lying)


def fit_pose(corners: "np.ndarray", board: Board, eye: Intrinsics) -> Calibration:
    """The pose from which the board's corners appear as they do; raises ActionFailed.

    A flat board looks much the same from two places: both are found (IPPE, Collins and Bartoli
    2014, doi:10.1007/s11263-014-0725-5), refined (Levenberg-Marquardt) and compared.
    """
    import numpy as np

    points, pixels = board.corners_mm().reshape(-1, 3), corners.reshape(-1, 2).astype(float)
    fits = _places(points, pixels, eye)
    if not fits:
        raise ActionFailed("PoorFit", "the corners do not fit any camera position")
    rms, pose = fits[0]
    middle = points.mean(axis=0)
    _check_above(pose)
    _check_fit(rms)
    _check_slant(pose, middle)
    if len(fits) > 1 and fits[1][0] < AS_GOOD * rms and fits[1][1].place_mm[2] > 0:
        _check_other(pose, fits[1][1], middle)
    covariance = _covariance(pose, points, middle, max(rms, SURE_PX * np.sqrt(2)), eye)
    return Calibration(pose, rms, middle, covariance, board)


def _places(
    points: "np.ndarray", pixels: "np.ndarray", eye: Intrinsics
) -> list[tuple[float, Pose]]:
    """Positions that fit, each with its reprojection error, the best first."""
    import cv2
    import numpy as np

    fits: list[tuple[float, Pose]] = []
    lens = eye.matrix, eye.distortion
    # IPPE wants its points about zero; what is found is moved back afterwards.
    middle = points.mean(axis=0)
    about = points - middle
    try:
        _, turns, shifts, _ = cv2.solvePnPGeneric(about, pixels, *lens, flags=cv2.SOLVEPNP_IPPE)
    except cv2.error:  # the corners lie on one line
        return []
    for turned, shift in zip(turns, shifts, strict=True):
        turned, shift = cv2.solvePnPRefineLM(about, pixels, *lens, turned, shift)
        turn = cv2.Rodrigues(turned)[0]
        pose = Pose(turn, middle - turn.T @ shift.ravel())
        off = pose.project(points, eye) - pixels
        rms = float(np.sqrt(np.mean(np.sum(off**2, axis=1))))
        if np.isfinite(rms):
            fits.append((rms, pose))
    return sorted(fits, key=lambda fit: fit[0])


def _check_above(pose: Pose) -> None:
    if pose.place_mm[2] <= 0:
        raise ActionFailed(
            "BoardMirrored",
            f"the corners put the camera {-pose.place_mm[2]:.0f} mm under the bench: "
            "the picture is mirrored",
        )


def _check_fit(rms_px: float) -> None:
    if rms_px > POOR_PX:
        raise ActionFailed(
            "PoorFit",
            f"the corners are {rms_px:.2f} pixels (rms) from where a flat board and a still camera "
            f"would put them; up to {POOR_PX:g} is good: lay the board flat, avoid vibration, "
            "and check that the lens is the one that was measured",
        )


def _check_slant(pose: Pose, middle: "np.ndarray") -> None:
    import numpy as np

    sight = middle - pose.place_mm
    slant = float(np.degrees(np.arccos(-sight[2] / np.linalg.norm(sight))))
    if slant > STEEP_DEG:
        raise ActionFailed(
            "PoorFit",
            f"the board is seen at {slant:.0f} degrees from straight above; beyond {STEEP_DEG:g} its corners "
            "do not locate the camera accurately: 20 to 45 is best",
        )


def _check_other(pose: Pose, other: Pose, middle: "np.ndarray") -> None:
    import numpy as np

    apart = float(np.linalg.norm(pose.place_mm - other.place_mm))
    if apart > ELSEWHERE * float(np.linalg.norm(middle - pose.place_mm)):
        raise ActionFailed(
            "PoorFit",
            f"two camera positions, {apart:.0f} mm apart, fit the corners equally well: the board is "
            "too small in the picture; go nearer, or look at it from 20 to 45 degrees",
        )


def _covariance(
    pose: Pose, points: "np.ndarray", middle: "np.ndarray", rms_px: float, eye: Intrinsics
) -> "np.ndarray":
    """(J'J)^-1 s^2, where J is how the pixels move with each of the pose's six parameters."""
    import numpy as np

    here = pose.project(points, eye)
    moved = [pose.nudged(middle, n[:3], n[3:]) for n in np.eye(6) * SLOPE]
    slopes = np.stack([(other.project(points, eye) - here).ravel() for other in moved], 1) / SLOPE
    freedom = len(points) / (len(points) - 3)  # six parameters were fitted, two values per point
    return np.linalg.inv(slopes.T @ slopes) * rms_px**2 / 2 * freedom
