"""Turn the mask of a thing on the bench into an outline, with its middle, size and area."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

FINE = 4  # an outline is drawn this many times finer than a cell
CUT_MM = 1.0  # how far an outline may cut a corner


def described(
    mask: "np.ndarray", corner_mm: "np.ndarray", cell_mm: float, height_mm: float
) -> dict[str, Any]:
    """What a protocol gets to know about a thing: mm and mm**2 on the bench.

    `mask` holds one thing; `corner_mm` is the left front corner of its first cell. Holes in the
    thing count as part of it.
    """
    import cv2
    import numpy as np

    rows, columns = np.nonzero(mask)
    top, left = rows.min() - 2, columns.min() - 2
    own = np.zeros((rows.max() - top + 3, columns.max() - left + 3), np.uint8)
    own[rows - top, columns - left] = 255
    # Drawn finely and softly: the corners of cells are not corners of the thing.
    fine = cv2.resize(own, None, fx=FINE, fy=FINE, interpolation=cv2.INTER_NEAREST)
    fine = (cv2.GaussianBlur(fine, (0, 0), FINE / 2) >= 128).astype(np.uint8)
    contours, _ = cv2.findContours(fine, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    contour = max(contours, key=cv2.contourArea)
    whole = cv2.drawContours(np.zeros_like(fine), [contour], -1, 1, cv2.FILLED)
    step = cell_mm / FINE
    begin = corner_mm + np.array([left, top]) * cell_mm + step / 2
    y, x = np.nonzero(whole)
    middle = begin + np.array([x.mean(), y.mean()]) * step
    drawn = cv2.approxPolyDP(contour, CUT_MM / step, True).reshape(-1, 2)
    outline = begin + drawn * step
    (low_x, low_y), (high_x, high_y) = outline.min(axis=0), outline.max(axis=0)
    return {
        "outline": [{"x": _tenth(a), "y": _tenth(b)} for a, b in outline],
        "x": _tenth(middle[0]), "y": _tenth(middle[1]),
        "left": _tenth(low_x), "right": _tenth(high_x),
        "front": _tenth(low_y), "back": _tenth(high_y),
        "area": round(float(whole.sum()) * step**2, 1),
        "height": _tenth(height_mm),
    }  # fmt: skip


def _tenth(value: float) -> float:
    return round(float(value), 1)
