"""Arrange the values of scattered points on the grid that they were measured on."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..spectrum.spectrum import FloatArray, IntArray

SAME_PLACE_DECIMALS = 6  # a nanometre in a map of millimetres: 0.2 * 3 is 0.6 again
SAME_STEP = 0.01  # how much of a step a coordinate may be off and still be on the grid
WIDE = 3  # steps between two places beyond which they belong to no common grid
MOST_FILLED = 10  # rows put in for each that was measured; more is no grid but scattered points


@dataclass(frozen=True, slots=True, eq=False)
class ElementMap:
    """Values on a grid: x shape (nx,), y shape (ny,), both ascending; values (ny, nx).

    NaN is a hole: a point that was not measured, or that failed.
    """

    x: FloatArray
    y: FloatArray
    values: FloatArray


def element_map(x: ArrayLike, y: ArrayLike, values: ArrayLike) -> ElementMap:
    """The map of values measured at the points (x, y); three shapes (n,), in any order.

    Columns and rows are the distinct coordinates; where these are multiples of one step, the ones
    that are missing between are put in as holes. Between places far apart, such as two samples, a
    hole a step wide ends each of them. A point measured more than once gets the mean.
    Raises ValueError when the shapes differ or a coordinate is not a number.
    """
    x, y, values = (np.asarray(given, dtype=np.float64) for given in (x, y, values))
    if not x.shape == y.shape == values.shape or x.ndim != 1:
        raise ValueError(f"{x.shape} x, {y.shape} y and {values.shape} values are not one list")
    if not (np.isfinite(x).all() and np.isfinite(y).all()):
        raise ValueError("a point of the map has a coordinate that is not a number")
    (x_axis, column), (y_axis, row) = _axis(x), _axis(y)
    shape = (len(y_axis), len(x_axis))
    measured = np.isfinite(values)
    cell = row[measured] * shape[1] + column[measured]
    total = np.bincount(cell, values[measured], minlength=shape[0] * shape[1])
    count = np.bincount(cell, minlength=shape[0] * shape[1])
    mean = np.divide(total, count, out=np.full(len(total), np.nan), where=count > 0)
    return ElementMap(x_axis, y_axis, mean.reshape(shape))


def _axis(places: FloatArray) -> tuple[FloatArray, IntArray]:
    """The grid lines along one direction, and on which of them each place lies."""
    distinct, which = np.unique(np.round(places, SAME_PLACE_DECIMALS), return_inverse=True)
    if len(distinct) < 3:
        return distinct, which
    step = np.diff(distinct).min()
    steps = (distinct - distinct[0]) / step
    on_grid = np.abs(steps - np.round(steps)) < SAME_STEP
    n_lines = int(np.round(steps[-1])) + 1
    if not on_grid.all() or n_lines > MOST_FILLED * len(distinct):
        return _with_gaps(distinct, which, step)
    regular = np.linspace(distinct[0], distinct[-1], n_lines)
    return np.round(regular, SAME_PLACE_DECIMALS), np.round(steps).astype(np.int64)[which]


def _with_gaps(distinct: FloatArray, which: IntArray, step: float) -> tuple[FloatArray, IntArray]:
    """The lines of places that lie on no grid, with empty ones where groups of them end."""
    wide = np.flatnonzero(np.diff(distinct) > WIDE * step)
    ends = np.concatenate((distinct[wide] + step, distinct[wide + 1] - step))
    lines = np.unique(np.round(np.concatenate((distinct, ends)), SAME_PLACE_DECIMALS))
    return lines, np.searchsorted(lines, distinct)[which]
