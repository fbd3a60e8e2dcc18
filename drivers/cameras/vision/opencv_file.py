"""A camera in OpenCV's own YAML, XML or JSON (cv2.FileStorage), with the names its samples use."""

from typing import TYPE_CHECKING, Any

from .camera import Camera, CameraFault
from .intrinsics import Intrinsics

if TYPE_CHECKING:
    import numpy as np

MATRIX = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "K", "M1", "K1", "cameraMatrix1")
DISTORTION = (
    "distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D", "D1",
    "distCoeffs1",
)  # fmt: skip
MATRIX_2, DISTORTION_2 = ("M2", "K2", "cameraMatrix2"), ("D2", "distCoeffs2")
WIDTH, HEIGHT = ("image_width", "image_Width", "width"), ("image_height", "image_Height", "height")
RMS = ("avg_reprojection_error", "Avg_Reprojection_Error", "rms")


def is_opencv(text: str) -> bool:
    """Whether OpenCV wrote it."""
    return text.startswith("%YAML") or "opencv-matrix" in text or "<opencv_storage" in text


def opencv_camera(text: str) -> Camera:
    """One eye, or two if a second one's matrices and R and T (mm) are there; raises CameraFault."""
    import cv2

    try:
        storage = cv2.FileStorage(text, cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY)
    except (cv2.error, SystemError) as fault:
        raise CameraFault("OpenCV cannot read this, though it looks like an OpenCV file") from fault
    try:
        return _camera(storage)
    except cv2.error as fault:
        raise CameraFault(f"OpenCV cannot read this: {fault.err}") from fault
    finally:
        storage.release()


def _camera(storage: Any) -> Camera:
    size = int(_number(storage, WIDTH) or 0), int(_number(storage, HEIGHT) or 0)
    left = Intrinsics(*size, _square(storage, MATRIX), _row(storage, DISTORTION))
    rms = _number(storage, RMS)
    if _found(storage, MATRIX_2) is None:
        return Camera(left, rms_px=rms)
    right = Intrinsics(*size, _square(storage, MATRIX_2), _row(storage, DISTORTION_2))
    turn, shift = _matrix(storage, ("R",)), _matrix(storage, ("T",))
    if turn is None or shift is None:
        raise CameraFault("there are two eyes, but R and T, their relative position, are missing")
    return Camera(left, right, turn.reshape(3, 3), shift.ravel(), rms_px=rms)


def _found(storage: Any, names: tuple[str, ...]) -> Any:
    nodes = (storage.getNode(name) for name in names)
    return next((node for node in nodes if not node.empty()), None)


def _number(storage: Any, names: tuple[str, ...]) -> float | None:
    node = _found(storage, names)
    return float(node.real()) if node is not None and (node.isReal() or node.isInt()) else None


def _matrix(storage: Any, names: tuple[str, ...]) -> "np.ndarray | None":
    import numpy as np

    node = _found(storage, names)
    found = node.mat() if node is not None else None
    return None if found is None else np.asarray(found, float)


def _square(storage: Any, names: tuple[str, ...]) -> "np.ndarray":
    found = _matrix(storage, names)
    if found is None or found.shape != (3, 3) or min(found[0, 0], found[1, 1]) <= 0:
        raise CameraFault(f"there is no camera matrix of 3 x 3 numbers under {', '.join(names)}")
    return found


def _row(storage: Any, names: tuple[str, ...]) -> "np.ndarray":
    found = _matrix(storage, names)
    if found is None or found.size not in (4, 5, 8, 12, 14):
        raise CameraFault(f"there is no distortion of 4 to 14 numbers under {', '.join(names)}")
    return found.ravel()
