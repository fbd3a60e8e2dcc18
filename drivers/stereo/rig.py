"""The two eyes: alike, side by side, their pictures rectified."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np


@dataclass(frozen=True, slots=True)
class Rig:
    """What the maker measured; pixels are counted from the middle of the first one.

    The right eye stands `baseline_mm` from the left one along the pictures' rows.
    """

    width: int = 1280
    height: int = 720
    focal_px: float = 1065.0
    baseline_mm: float = 60.0

    @property
    def middle(self) -> tuple[float, float]:
        """The pixel in the line of sight."""
        return (self.width - 1) / 2, (self.height - 1) / 2

    def matrix(self) -> "np.ndarray":
        """The camera matrix K: pixel = K (x, y, z), up to a factor."""
        import numpy as np

        u, v = self.middle
        return np.array([[self.focal_px, 0, u], [0, self.focal_px, v], [0, 0, 1.0]])

    def holds(self, u: float, v: float) -> bool:
        """Whether the pictures have such a pixel."""
        return 0 <= u <= self.width - 1 and 0 <= v <= self.height - 1
