"""Read pictures and depth maps from files, and explain why a file is not one."""

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

PICTURES = (".png", ".jpg", ".jpeg", ".bmp", ".tif", ".tiff", ".webp", ".pgm", ".ppm")
DEPTHS = (".png", ".tif", ".tiff", ".npy", ".pgm")
TENTH_MM = 0.1  # the unit of labrun's own 16-bit depth maps
LARGEST = 500_000_000  # bytes


class PictureFault(ValueError):
    """A file without a usable picture; the text says which and why."""


def read_picture(path: Path) -> "np.ndarray":
    """A picture as OpenCV holds it (8 bit, blue first), as the chip saw it; raises PictureFault."""
    import cv2

    flags = cv2.IMREAD_COLOR | cv2.IMREAD_IGNORE_ORIENTATION
    return _decoded(path, flags, "picture (PNG, JPEG, TIFF, BMP, WebP)")


def read_depth(path: Path, unit_mm: float | None = None) -> "np.ndarray":
    """Depth in mm for every pixel, NaN where unknown; raises PictureFault.

    A 16-bit PNG counts in `unit_mm` (default 0.1 mm, as labrun writes it) and 0 is unknown;
    NumPy's .npy and a TIFF of floating-point numbers are in millimetres by default.
    """
    import cv2
    import numpy as np

    if path.suffix.lower() == ".npy":
        raw = _array(path)
    else:
        raw = _decoded(path, cv2.IMREAD_UNCHANGED, "depth map (16-bit PNG, float TIFF, .npy)")
    if raw.ndim != 2 or raw.dtype == np.uint8:
        raise PictureFault(
            f"{path} is a picture of {raw.dtype.itemsize * 8} bits, not a depth map: a depth map has one "
            "value per pixel, 16 bits or floating point"
        )
    step = unit_mm or (TENTH_MM if raw.dtype.kind in "ui" else 1.0)
    depth = raw.astype(np.float32) * np.float32(step)
    return np.where(np.isfinite(depth) & (depth > 0), depth, np.nan)


def same_picture_size(pictures: dict[str, "np.ndarray"]) -> tuple[int, int]:
    """Width and height of all the pictures; raises PictureFault if the sizes differ."""
    sizes: dict[tuple[int, int], list[str]] = {}
    for name, picture in pictures.items():
        sizes.setdefault((picture.shape[1], picture.shape[0]), []).append(name)
    if len(sizes) > 1:
        most_first = sorted(sizes.items(), key=lambda pair: -len(pair[1]))
        told = "; ".join(f"{w} x {h}: {_some(names)}" for (w, h), names in most_first)
        raise PictureFault(
            f"the pictures have different sizes, and a lens is measured at one: {told}"
        )
    return next(iter(sizes))


def _some(names: list[str], most: int = 3) -> str:
    more = len(names) - most
    return ", ".join(names[:most]) + (f" and {more} more" if more > 0 else "")


def _bytes(path: Path, wanted: str) -> bytes:
    try:
        if path.stat().st_size > LARGEST:
            raise PictureFault(f"{path} is too large for a {wanted}")
        data = path.read_bytes()
    except OSError as fault:
        raise PictureFault(f"{path} cannot be read: {fault.strerror or fault}") from fault
    if not data:
        raise PictureFault(f"{path} is empty")
    return data


def _decoded(path: Path, flags: int, wanted: str) -> "np.ndarray":
    import cv2
    import numpy as np

    data = np.frombuffer(_bytes(path, wanted), np.uint8)
    try:
        picture = cv2.imdecode(data, flags)
    except cv2.error:  # more pixels than OpenCV takes
        picture = None
    if picture is None:
        raise PictureFault(f"{path} is not a {wanted}, or it is damaged")
    return picture


def _array(path: Path) -> "np.ndarray":
    import io

    import numpy as np

    try:
        found = np.load(io.BytesIO(_bytes(path, "depth map")), allow_pickle=False)
        if found.dtype.kind not in "uif":
            raise ValueError("not numbers")
    except (ValueError, EOFError, OSError) as fault:
        raise PictureFault(f"{path} is not a NumPy array of numbers, or it is damaged") from fault
    return found
