"""Which cells of a plan differ from the bench: in colour, brighter, or darker than a shadow.

The bench is what there is most of. A shadow darkens it but keeps its colours, so colours separate
a sample in the shade from bench in the shade; graininess counts as another colour.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    import numpy as np

FAINT, BLACK = 80.0, 8.0  # grey levels below which colours are noise, and brightness is
GRAIN_MM = 2.5  # over which a rock's grains are averaged
SEED_MM = 5.0  # least width of a thing
FAR_COLOUR, FAR_BRIGHT = 5.0, 4.0  # robust standard deviations from the bench
SAME_COLOUR = 0.01  # ratio of two indistinguishable colours, less one
PLAIN_COLOUR = 0.05  # and of two that are easily distinguished
CALM_COLOUR, CALM_BRIGHT = 0.15, 0.04  # the least that a bench is taken to vary, in logarithms
SHADOW = 0.2  # of the bench's brightness is left in the deepest shadow of a lit room
NEWS = 0.2  # of a thing has to be new, or it was already found
ROUNDS, SAMPLED = 4, 20_000


def unlike_bench(picture: "np.ndarray", known: "np.ndarray", cell_mm: float) -> "np.ndarray":
    """True for cells that are not bench; `known` marks the cells to consider. Shapes as the plan."""
    import numpy as np

    if not known.any():
        return known
    grain = GRAIN_MM / cell_mm
    colours = np.log(picture.astype(np.float32) + FAINT)
    red = _levelled(colours[..., 2] - colours[..., 1], known)
    blue = _levelled(colours[..., 0] - colours[..., 1], known)
    hue = red**2 + blue**2
    energy = _calmed(hue, known, grain)
    coloured = _calmed(hue / (hue + PLAIN_COLOUR**2), known, grain)  # no grain outweighs another
    colour = _apart(0.5 * np.log(energy + SAME_COLOUR**2), known, CALM_COLOUR) / FAR_COLOUR
    light = np.log(picture.astype(np.float32).mean(axis=-1) + BLACK)
    light = _calmed(_levelled(light, known), known, grain)
    bright = _apart(light, known, CALM_BRIGHT) / FAR_BRIGHT
    black = np.where(light < np.log(SHADOW), -bright, 0)
    found = np.zeros_like(known)
    for amount, far in ((-light, black), (coloured, colour), (light, bright)):
        for rows, columns, thing in _things(amount, far > 1, known, cell_mm):
            # The most certain first: what is black has no colours, and a coloured edge is sharper than a
            # bright one. What was found is not found again, and keeps its edge.
            if (thing & ~found[rows, columns]).sum() > NEWS * thing.sum():
                found[rows, columns] |= thing
    return found & known


def _things(
    amount: "np.ndarray", far: "np.ndarray", known: "np.ndarray", cell_mm: float
) -> "Iterator[tuple[slice, slice, np.ndarray]]":
    """Grow what differs from the bench to where it is halfway between the bench and the thing.

    A step that was blurred is halfway at its true place.
    """
    import cv2
    import numpy as np

    reach = max(3, 2 * round(SEED_MM / 2 / cell_mm) + 1)
    brush = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (reach, reach))
    seeds = (known & far).astype(np.uint8)
    seeds = cv2.morphologyEx(seeds, cv2.MORPH_CLOSE, brush)
    seeds = cv2.morphologyEx(seeds, cv2.MORPH_OPEN, brush)
    bench = float(np.median(amount[known]))
    count, labels, boxes, _ = cv2.connectedComponentsWithStats(seeds)
    for label in range(1, count):
        left, top, width, height, _ = boxes[label]
        rows = slice(max(0, top - 2 * reach), top + height + 2 * reach)
        columns = slice(max(0, left - 2 * reach), left + width + 2 * reach)
        seed = (labels[rows, columns] == label).astype(np.uint8)
        inside = float(np.median(amount[rows, columns][seed > 0]))
        near = cv2.dilate(seed, brush, iterations=2) > 0
        grown = (near & (amount[rows, columns] > (bench + inside) / 2)).astype(np.uint8)
        grown = cv2.morphologyEx(grown, cv2.MORPH_CLOSE, brush)
        yield rows, columns, cv2.morphologyEx(grown, cv2.MORPH_OPEN, brush) > 0


def _apart(feature: "np.ndarray", known: "np.ndarray", least: float) -> "np.ndarray":
    """How many robust standard deviations a feature lies above the bench."""
    import numpy as np

    middle = float(np.median(feature[known]))
    spread = 1.4826 * float(np.median(np.abs(feature[known] - middle)))
    return (feature - middle) / max(spread, least)


def _levelled(feature: "np.ndarray", known: "np.ndarray") -> "np.ndarray":
    """The feature without its slow changes over the bench, such as those of the light."""
    import numpy as np

    rows, columns = np.nonzero(known)
    few = slice(None, None, max(1, len(rows) // SAMPLED))
    height, width = feature.shape
    at = _slow(columns[few] / width, rows[few] / height)
    values = feature[rows[few], columns[few]]
    kept = np.ones(len(values), bool)
    slope = np.zeros(at.shape[1])
    for _ in range(ROUNDS):
        slope = np.linalg.lstsq(at[kept], values[kept], rcond=None)[0]
        off = np.abs(values - at @ slope)
        kept = off <= 2.5 * 1.4826 * np.median(off) + 1e-9
        if kept.sum() < 20:
            break
    y, x = np.mgrid[:height, :width].astype(np.float32)
    return feature - (_slow(x / width, y / height) @ slope.astype(np.float32))


def _slow(x: "np.ndarray", y: "np.ndarray") -> "np.ndarray":
    import numpy as np

    return np.stack([np.ones_like(x), x, y, x * y, x**2, y**2], axis=-1)


def _calmed(feature: "np.ndarray", known: "np.ndarray", cells: float) -> "np.ndarray":
    """Blurred, without leaking in from beyond the known cells."""
    import cv2
    import numpy as np

    share = known.astype(np.float32)
    weighed = cv2.GaussianBlur(np.where(known, feature, 0).astype(np.float32), (0, 0), cells)
    return weighed / np.maximum(cv2.GaussianBlur(share, (0, 0), cells), 1e-3)
