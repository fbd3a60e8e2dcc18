"""Scales that a map of areas may be shown on: from lowest to highest, absolute, part of the total.

`min-max` is the paper's. `total` divides by the light of the whole spectrum, which takes out how
much one shot happened to ablate: of the simple internal references the one that needs no element
that is the same everywhere (Body and Chadwick, Spectrochim. Acta B 56, 725 (2001); Zorov et al.,
Spectrochim. Acta B 65, 642 (2010)). The whole is the sum of all fitted peaks where the tables have
them, else of the elements that the rows have.
"""

from typing import Literal

import numpy as np

from ...spectrum.spectrum import FloatArray
from .points import Points

Scale = Literal["min-max", "absolute", "total"]
SCALES: tuple[Scale, ...] = ("min-max", "absolute", "total")
UNITS: dict[str, str] = {"min-max": "", "absolute": "counts nm", "total": "% of all peaks"}


def on_scale(points: Points, element: str, scale: Scale) -> FloatArray:
    """The area of an element at all points on a scale, shape (n,); NaN stays.

    min-max: 0 to 1 over all samples, a flat one is 0; absolute: counts nm; total: per cent.
    """
    area = points.area[element]
    if scale == "absolute":
        return area
    if scale == "total":
        total = total_light(points)
        return np.divide(100 * area, total, out=np.full(len(area), np.nan), where=total > 0)
    known = area[np.isfinite(area)]
    if not len(known):
        return area
    span = float(np.ptp(known))
    return (area - known.min()) / span if span > 0 else area - known.min()


def total_light(points: Points) -> FloatArray:
    """The area of all peaks of each point, else of all its elements, counts nm, shape (n,)."""
    areas = [np.nan_to_num(area) for area in points.area.values()]
    summed = np.sum(areas, axis=0) if areas else np.full(len(points), np.nan)
    return np.where(np.isfinite(points.total), points.total, summed)
