"""Find what stands out from the bench in a cloud of bench points."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np

CELL_MM = 2.0
GAP = 5  # cells that a hole in the depth may be wide
SPECK = 3  # cells; thinner things are faults of the depth
SMOOTH_MM = 3.0  # how far an outline may cut a corner


def find_samples(
    points_mm: "np.ndarray", min_height_mm: float, min_area_mm2: float
) -> list[dict[str, Any]]:
    """Outline, centre and height of each thing, the largest first; all in mm on the bench."""
    import cv2
    import numpy as np

    high = points_mm[points_mm[:, 2] >= min_height_mm]
    if not len(high):
        return []
    corner = high[:, :2].min(axis=0) - 2 * GAP * CELL_MM
    cells = np.floor((high[:, :2] - corner) / CELL_MM).astype(int)
    shape = cells.max(axis=0)[::-1] + 2 * GAP
    mask = np.zeros(shape, np.uint8)
    mask[cells[:, 1], cells[:, 0]] = 1
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((GAP, GAP), np.uint8))
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((SPECK, SPECK), np.uint8))
    count, labels = cv2.connectedComponents(mask)
    of_point = labels[cells[:, 1], cells[:, 0]]
    found = []
    for label in range(1, count):
        thing = (labels == label).astype(np.uint8)
        area = float(thing.sum()) * CELL_MM**2
        if area >= min_area_mm2:
            height = float(np.median(high[of_point == label, 2]))
            found.append((area, _described(thing, corner, height)))
    return [sample for _, sample in sorted(found, key=lambda pair: -pair[0])]


def _described(thing: "np.ndarray", corner: "np.ndarray", height_mm: float) -> dict[str, Any]:
    import cv2
    import numpy as np

    contours, _ = cv2.findContours(thing, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    contour = max(contours, key=cv2.contourArea)
    outline = cv2.approxPolyDP(contour, SMOOTH_MM / CELL_MM, True).reshape(-1, 2)
    rows, columns = np.nonzero(thing)
    x, y = corner + (np.array([columns.mean(), rows.mean()]) + 0.5) * CELL_MM
    places = corner + (outline + 0.5) * CELL_MM
    return {
        "outline": [{"x": round(float(a), 1), "y": round(float(b), 1)} for a, b in places],
        "x": round(float(x), 1),
        "y": round(float(y), 1),
        "height": round(height_mm, 1),
    }
