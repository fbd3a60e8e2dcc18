"""Points of a map: identity, coordinates, and measured values."""

from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ...spectrum.spectrum import BoolArray, FloatArray, IntArray
from ..maps import SAME_PLACE_DECIMALS
from .contents import Contents, averaged
from .reduced import Reduced


@dataclass(frozen=True, slots=True, eq=False)
class Points:
    """Arrays of shape (n,), a point each.

    name: its spectrum, key or row. x, y: in `unit`, NaN where the place is unknown. area and
    area_error by element, counts nm: 0 where no peak stands, NaN where nothing was measured.
    line_nm: the line that stands for an element, where it is known. total: of all peaks, NaN where
    unknown. spectrum: index into the tables `reduced`, -1 for none. notes: sentences about what was
    compared and what was left out. inputs: the files that were read. contents: by element, where a
    calibration was used.
    """

    name: list[str]
    sample: list[str]
    x: FloatArray
    y: FloatArray
    unit: str
    area: dict[str, FloatArray]
    area_error: dict[str, FloatArray]
    line_nm: dict[str, float]
    total: FloatArray
    temperature_k: FloatArray
    temperature_error_k: FloatArray
    log10_ne: FloatArray
    spectrum: IntArray
    reduced: Reduced | None
    notes: list[str] = field(default_factory=list)
    inputs: list[Path] = field(default_factory=list)
    contents: dict[str, Contents] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.name)

    @property
    def placed(self) -> BoolArray:
        return np.isfinite(self.x) & np.isfinite(self.y)

    @property
    def measured(self) -> BoolArray:
        """Mask of points where anything is known, even that there is no signal."""
        known = np.isfinite(self.total)
        for area in self.area.values():
            known |= np.isfinite(area)
        for contents in self.contents.values():
            known |= contents.known
        return known

    @property
    def lit(self) -> BoolArray:
        """Mask of points with a signal of any element."""
        bright = self.total > 0
        for area in self.area.values():
            bright |= area > 0
        for contents in self.contents.values():
            bright |= contents.value > 0
        return bright

    def of_sample(self, sample: str) -> BoolArray:
        return np.array([one == sample for one in self.sample]) & self.placed


def merged(points: Points) -> Points:
    """The same points, with repeated measurements of a place averaged into one.

    Errors of areas are those of the mean. What has no place stays as it is.
    """
    x, y = (np.round(axis, SAME_PLACE_DECIMALS) for axis in (points.x, points.y))
    groups: dict[tuple, list[int]] = {}
    for at in range(len(points)):
        place = (points.sample[at], x[at], y[at]) if points.placed[at] else (at,)
        groups.setdefault(place, []).append(at)
    if len(groups) == len(points):
        return points
    which = np.empty(len(points), dtype=np.int64)
    for index, members in enumerate(groups.values()):
        which[members] = index
    first = np.array([members[0] for members in groups.values()])
    doubled = sum(len(members) > 1 for members in groups.values())
    places = "a place was" if doubled == 1 else f"{doubled} places were"
    note = f"{places} measured more than once; the mean is shown"
    return Points(
        [points.name[at] for at in first], [points.sample[at] for at in first],
        points.x[first], points.y[first], points.unit,
        {e: _mean(area, which) for e, area in points.area.items()},
        {e: _error_of_mean(error, which) for e, error in points.area_error.items()},
        points.line_nm, _mean(points.total, which), _mean(points.temperature_k, which),
        _error_of_mean(points.temperature_error_k, which), _mean(points.log10_ne, which),
        points.spectrum[first], points.reduced, [*points.notes, note], points.inputs,
        {e: averaged(one, which) for e, one in points.contents.items()},
    )  # fmt: skip


def _mean(values: FloatArray, which: IntArray) -> FloatArray:
    """The mean of the known values in each group, NaN if there are none."""
    known = np.isfinite(values)
    n = int(which.max()) + 1
    total = np.bincount(which[known], values[known], n)
    count = np.bincount(which[known], minlength=n)
    return np.divide(total, count, out=np.full(n, np.nan), where=count > 0)


def _error_of_mean(error: FloatArray, which: IntArray) -> FloatArray:
    known = np.isfinite(error)
    n = int(which.max()) + 1
    squares = np.bincount(which[known], error[known] ** 2, n)
    count = np.bincount(which[known], minlength=n)
    return np.divide(np.sqrt(squares), count, out=np.full(n, np.nan), where=count > 0)
