"""Find the things on the bench: what stands out from it, and what looks different."""

from typing import TYPE_CHECKING, Any

from .foreground import unlike_bench
from .outline import described
from .pixel_position import bench_points
from .plan import Plan, board_cells, plan_of

if TYPE_CHECKING:
    import numpy as np

    from .pose import Calibration
    from .view import View

CELL_MM = 2.0  # of the height map; the colour map is twice as fine
GAP = 5  # cells: the widest hole in the depth that is filled
SPECK = 3  # cells; thinner things are errors of the depth
NOISE = 4.0  # robust standard deviations of the bench's own height that a thing has to stand out
AROUND_MM = 6.0  # things that stand out appear wider in the depth than they are


def find_samples(
    view: "View", fit: "Calibration", min_height_mm: float, min_area_mm2: float, flat: bool
) -> list[dict[str, Any]]:
    """Outline, middle, size, area and height of each thing, the largest first; raises ActionFailed.

    The board is not included, as long as it is where it was during calibration.
    """
    points = bench_points(fit.pose, view.eye, view.depth)
    level, least = _bench_level(points[..., 2], min_height_mm)
    high = points[..., 2] - level >= least
    found = _standing(points, high, level)
    plan = plan_of(view.picture, fit.pose, view.eye)
    if plan is not None:
        board = board_cells(plan, fit.board)
        found = [thing for thing in found if not _lies_on(board, plan, thing)]
        if flat:
            hidden = board | _hidden(high, fit, view, plan)
            found += _flat(unlike_bench(plan.picture, plan.seen & ~hidden, plan.cell_mm), plan)
    kept = [thing for thing in found if thing["area"] >= min_area_mm2]
    return sorted(kept, key=lambda thing: -thing["area"])


def _bench_level(heights: "np.ndarray", min_height_mm: float) -> tuple[float, float]:
    """The bench height that the eyes see, a little off zero, and the height that stands out."""
    import numpy as np

    low = heights[np.isfinite(heights) & (np.abs(heights) < max(min_height_mm, 10))]
    if not len(low):
        return 0.0, min_height_mm
    level = float(np.median(low))
    spread = 1.4826 * float(np.median(np.abs(low - level)))
    return level, max(min_height_mm, NOISE * spread)


def _standing(points: "np.ndarray", high: "np.ndarray", level_mm: float) -> list[dict[str, Any]]:
    """What stands out, from the points that the eyes see."""
    import cv2
    import numpy as np

    tops = points[high]
    if not len(tops):
        return []
    corner = tops[:, :2].min(axis=0) - 2 * GAP * CELL_MM
    cells = np.floor((tops[:, :2] - corner) / CELL_MM).astype(int)
    mask = np.zeros(cells.max(axis=0)[::-1] + 2 * GAP, np.uint8)
    mask[cells[:, 1], cells[:, 0]] = 1
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((GAP, GAP), np.uint8))
    mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, np.ones((SPECK, SPECK), np.uint8))
    count, labels = cv2.connectedComponents(mask)
    of_point = labels[cells[:, 1], cells[:, 0]]
    found = []
    for label in range(1, count):
        height = float(np.median(tops[of_point == label, 2])) - level_mm
        found.append(described(labels == label, corner, CELL_MM, height))
    return found


def _flat(mask: "np.ndarray", plan: Plan) -> list[dict[str, Any]]:
    import cv2
    import numpy as np

    count, labels = cv2.connectedComponents(mask.astype(np.uint8))
    things = (labels == label for label in range(1, count))
    return [described(thing, plan.corner_mm, plan.cell_mm, 0.0) for thing in things]


def _lies_on(covered: "np.ndarray", plan: Plan, thing: dict[str, Any]) -> bool:
    import numpy as np

    column, row = np.floor(plan.cells(np.array([thing["x"], thing["y"]]))).astype(int)
    height, width = covered.shape
    return bool(0 <= column < width and 0 <= row < height and covered[row, column])


def _hidden(high: "np.ndarray", fit: "Calibration", view: "View", plan: Plan) -> "np.ndarray":
    """Cells of the plan where something stands in front of the bench, and those near it."""
    import cv2
    import numpy as np

    reach = max(3, 2 * round(AROUND_MM / CELL_MM) + 1)
    brush = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    stands = cv2.morphologyEx(high.astype(np.uint8), cv2.MORPH_OPEN, brush)
    before = plan_of(stands, fit.pose, view.eye)
    if before is None:
        return np.zeros(plan.seen.shape, bool)
    cells = max(3, 2 * round(AROUND_MM / plan.cell_mm) + 1)
    wide = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (cells, cells))
    return cv2.dilate(before.picture, wide) > 0
