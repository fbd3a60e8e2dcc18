"""Put the features of points on one scale before distances between them are taken."""

import numpy as np

from ...spectrum.spectrum import FloatArray

FULL_QUANTILE = 0.95  # of the points where the element stands: what is 1 on the scale
MOST = 1.25  # a hot pixel is no further away than this


def scaled(area: FloatArray) -> FloatArray:
    """Areas of one element from 0 (no peak) to about 1 (as bright as where it is bright).

    area: counts nm, shape (n,), none below 0. Divided by the 0.95 quantile of the areas above 0,
    which neither one wild point nor the number of points without the element moves; cut at 1.25.
    It is the paper's min-max normalisation (the smallest area is 0 where the element is missing
    anywhere), made robust.
    """
    there = area[area > 0]
    if not len(there):
        return np.zeros(len(area))
    return np.minimum(area / np.quantile(there, FULL_QUANTILE), MOST)


def feature_table(areas: list[FloatArray]) -> FloatArray:
    """The scaled features of points, shape (n, features); NaN (not measured) counts as no peak."""
    return np.column_stack([scaled(np.nan_to_num(area).clip(0)) for area in areas])
