"""Values of points that lie on no grid: a line through them, or the area nearest to each."""

import numpy as np

from ..spectrum.spectrum import FloatArray
from .maps import ElementMap, element_map

PIXELS = 360  # along the longer side of a picture of scattered points
LEAST_FILLED = 0.3  # of the cells of a grid: with fewer measured it is none
REACH = 0.8  # of the distance to the nearest other point: how far a point speaks
STRAIGHT = 0.01  # of a line's length that its points may lie beside it


def map_of(x: FloatArray, y: FloatArray, values: FloatArray) -> ElementMap:
    """The map of points (n,): on their grid where there is one, else each with what is nearest to it.

    On a grid a point that is missing is a hole. Raises ValueError as `element_map` does.
    """
    grid = element_map(x, y, values)
    if len(x) < 3 or grid.values.size * LEAST_FILLED <= len(x):
        return grid
    return nearest_map(x, y, values)


def nearest_map(x: FloatArray, y: FloatArray, values: FloatArray) -> ElementMap:
    """A picture in which every place has the value of the nearest point, if that is near enough.

    Near is 0.8 of the distance from that point to its own nearest neighbour, or of the usual such
    distance if that is larger: fine and coarse parts of one map have cells of their own size, and
    what nobody measured stays empty.
    """
    from scipy.spatial import KDTree

    places = np.column_stack([x, y])
    tree = KDTree(places)
    apart = tree.query(places, k=2)[0][:, 1]
    half = 0.5 * float(np.quantile(apart, 0.95))
    low, high = places.min(axis=0) - half, places.max(axis=0) + half
    pixel = float((high - low).max()) / PIXELS
    axes = [np.arange(a + pixel / 2, b, pixel) for a, b in zip(low, high, strict=True)]
    across, up = np.meshgrid(*axes)
    away, nearest = tree.query(np.column_stack([across.ravel(), up.ravel()]))
    reach = REACH * np.maximum(apart, np.median(apart))
    seen = np.where(away <= reach[nearest], values[nearest], np.nan)
    return ElementMap(axes[0], axes[1], seen.reshape(across.shape))


def along_line(x: FloatArray, y: FloatArray) -> FloatArray | None:
    """How far along their common line the points lie, from the first end; None where there is none.

    The line begins at the lower x (or the lower y of an upright line). One point is no line.
    """
    places = np.column_stack([x, y])
    middle = places.mean(axis=0)
    _, length, direction = np.linalg.svd(places - middle, full_matrices=False)
    if len(x) < 2 or length[0] == 0 or (len(length) > 1 and length[1] > STRAIGHT * length[0]):
        return None
    axis = direction[0]
    way = (places - middle) @ (axis if axis[np.argmax(np.abs(axis))] > 0 else -axis)
    return way - way.min()
