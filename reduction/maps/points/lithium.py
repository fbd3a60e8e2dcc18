"""Lithium's own thermometer from the tables: the ratio of its two lines."""

from dataclasses import dataclass

import numpy as np

from ...lines.air import to_air
from ...plasma.lithium import ORANGE_NM, RED_NM
from ...spectrum.spectrum import FloatArray
from .reduced import Records, Reduced

NEAR_NM = 0.35  # air or vacuum, and off


@dataclass(frozen=True, slots=True, eq=False)
class Ratio:
    """Areas 610 / 670 and its standard error, shape (spectra,), NaN where a line is missing."""

    value: FloatArray
    error: FloatArray


def lithium_ratios(reduced: Reduced) -> Ratio:
    """The paper's ratio for every spectrum that shows both lines."""
    n = len(reduced.spectra)
    if reduced.peaks is None:
        return Ratio(np.full(n, np.nan), np.full(n, np.nan))
    (orange, orange_error), (red, red_error) = (
        _line(reduced.peaks, float(to_air(np.array(nm))), n) for nm in (ORANGE_NM, RED_NM)
    )
    ratio = orange / red
    return Ratio(ratio, ratio * np.hypot(orange_error / orange, red_error / red))


def _line(peaks: Records, air_nm: float, n: int) -> tuple[FloatArray, FloatArray]:
    own = (peaks.element == "Li") & (np.abs(peaks.line_nm - air_nm) < NEAR_NM) & (peaks.area > 0)
    chosen = np.flatnonzero(own)
    chosen = chosen[np.argsort(peaks.area[chosen], kind="stable")]  # the largest comes last
    area, error = np.full(n, np.nan), np.full(n, np.nan)
    area[peaks.at[chosen]], error[peaks.at[chosen]] = peaks.area[chosen], peaks.area_error[chosen]
    return area, error
