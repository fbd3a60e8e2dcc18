"""What spoils a pair of pictures: a hand over the board, no focus, a mirror, shaking, a shut eye.

The trouble is in the pictures; that there is trouble, the driver has to find out by itself.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

TROUBLES = ("covered", "blurred", "mirrored", "shaken", "one_eyed")
BLUR_PX = 14.0
SHAKE_PX, SHAKE_ROWS = 4.0, 300.0
Pair = tuple["np.ndarray", "np.ndarray"]


def spoil(pair: Pair, trouble: str, middle: tuple[float, float] | None) -> Pair:
    """The pair of pictures with this trouble; `middle` is where the board is in the left one."""
    left, right = pair
    match trouble:
        case "covered":
            return _covered(left, middle), _covered(right, middle)
        case "blurred":
            return _blurred(left), _blurred(right)
        case "mirrored":
            return left[:, ::-1].copy(), right[:, ::-1].copy()
        case "shaken":
            return _shaken(left), _shaken(right)
        case "one_eyed":
            return left, right * 0
    raise ValueError(
        f"{trouble!r} is not a camera trouble; the troubles are: {', '.join(TROUBLES)}"
    )


def _covered(picture: "np.ndarray", middle: tuple[float, float] | None) -> "np.ndarray":
    import cv2

    covered = picture.copy()
    height, width = picture.shape[:2]
    u, v = middle or (width / 2, height / 2)
    hand = (round(u), round(v)), (width // 8, height // 6), 30.0
    cv2.ellipse(covered, hand, (120, 150, 205), thickness=-1)
    return covered


def _blurred(picture: "np.ndarray") -> "np.ndarray":
    import cv2

    return cv2.GaussianBlur(picture, (0, 0), BLUR_PX)


def _shaken(picture: "np.ndarray") -> "np.ndarray":
    """Rows are read one after the other: while the camera shakes, each one from elsewhere."""
    import cv2
    import numpy as np

    height, width = picture.shape[:2]
    v, u = np.mgrid[:height, :width].astype(np.float32)
    u += SHAKE_PX * np.sin(2 * np.pi * v / SHAKE_ROWS).astype(np.float32)
    return cv2.remap(picture, u, v, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
