"""One lens and its chip: which ray a pixel sees, and which pixel a ray hits."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

ROUNDS = 20  # of undistortion, each about ten times closer than the last
CLOSE_PX = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class Intrinsics:
    """A pinhole with the distortion of OpenCV's manual (k1 k2 p1 p2 k3 ...), for one picture size.

    `matrix` is K, shape (3, 3), in pixels, counted from the middle of the first one.
    """

    width: int
    height: int
    matrix: "np.ndarray"
    distortion: "np.ndarray"

    @classmethod
    def ideal(cls, width: int, height: int, focal_px: float) -> "Intrinsics":
        """An ideal lens that looks straight through the middle of its pictures."""
        import numpy as np

        middle_u, middle_v = (width - 1) / 2, (height - 1) / 2
        matrix = np.array([[focal_px, 0, middle_u], [0, focal_px, middle_v], [0, 0, 1.0]])
        return cls(width, height, matrix, np.zeros(5))

    @property
    def focal_px(self) -> float:
        """The focal length along the rows."""
        return float(self.matrix[0, 0])

    def holds(self, u: float, v: float) -> bool:
        """Whether the pixel is inside the pictures."""
        return 0 <= u <= self.width - 1 and 0 <= v <= self.height - 1

    def pixels(self, seen: "np.ndarray") -> "np.ndarray":
        """Where points (right, down, ahead) of the camera appear: shape (..., 3) to (..., 2)."""
        import cv2
        import numpy as np

        points = np.ascontiguousarray(np.reshape(seen, (-1, 1, 3)), float)
        still = np.zeros(3)
        found = cv2.projectPoints(points, still, still, self.matrix, self.distortion)[0]
        return found.reshape(*np.shape(seen)[:-1], 2)

    def rays(self, pixels: "np.ndarray") -> "np.ndarray":
        """What pixels see: directions (right, down, 1), shape (..., 2) to (..., 3).

        OpenCV's `undistortPoints` stops after five rounds; the rest is removed here.
        """
        import cv2
        import numpy as np

        wanted = np.ascontiguousarray(np.reshape(pixels, (-1, 1, 2)), float)
        flat = cv2.undistortPoints(wanted, self.matrix, self.distortion).reshape(-1, 2)
        rays = np.concatenate([flat, np.ones((len(flat), 1))], axis=1)
        for _ in range(ROUNDS if np.any(self.distortion) else 0):
            off = wanted[:, 0] - self.pixels(rays)
            if np.abs(off).max() < CLOSE_PX:
                break
            rays[:, :2] += off / np.diag(self.matrix)[:2]
        return rays.reshape(*np.shape(pixels)[:-1], 3)
