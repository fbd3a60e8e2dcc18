"""Lithium from the tables: the ratio of its two lines, and its share of the cations.

The share takes every named peak as a thin line of a plasma of the spectrum's own temperature and
density: an element's amount is the median over its lines of area / shine. Strong lines absorb
themselves, so the share of what is much is too small; `labrun spectrum` corrects for that.
"""

from dataclasses import dataclass

import numpy as np

from ...lines.air import to_air
from ...plasma.lithium import ORANGE_NM, RED_NM
from ...plasma.lithium_share import NO_CATIONS
from ...plasma.strengths import atoms, log_strengths
from ...spectrum.spectrum import FloatArray, IntArray
from .reduced import Records, Reduced

USUAL_LOG10_NE = 17.0
NEAR_NM = 0.35  # air or vacuum, and off
SAME_NM = 0.06  # between a line in the tables and its rows in the line table
MOST_RELATIVE = 0.35  # error of an area that speaks


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


def lithium_shares(reduced: Reduced) -> FloatArray:
    """Lithium's part of all cations by atoms, shape (spectra,); NaN where the plasma is not known."""
    share = np.full(len(reduced.spectra), np.nan)
    peaks = reduced.peaks
    if peaks is None:
        return share
    good = (peaks.area > 0) & ~(peaks.area_error > MOST_RELATIVE * peaks.area)
    good &= np.isfinite(peaks.line_nm) & (peaks.element != "")
    good &= ~np.isin(peaks.element, sorted(NO_CATIONS))
    chosen = np.flatnonzero(good)
    rows, entry = _rows(peaks, chosen)
    chosen, first = chosen[np.unique(entry)], np.searchsorted(entry, np.unique(entry))
    order = np.argsort(peaks.at[chosen], kind="stable")
    ends = np.append(first[1:], len(rows))
    bounds = np.searchsorted(peaks.at[chosen][order], np.arange(len(share) + 1))
    for spectrum in np.flatnonzero(np.isfinite(reduced.temperature_k) & ~reduced.failed):
        own = order[bounds[spectrum] : bounds[spectrum + 1]]
        if not len(own):
            continue
        density = reduced.log10_ne[spectrum]
        density = USUAL_LOG10_NE if np.isnan(density) else density
        each = [rows[first[i] : ends[i]] for i in own]
        log = log_strengths(
            np.concatenate(each), float(reduced.temperature_k[spectrum]), float(10**density)
        )
        which = np.repeat(np.arange(len(own)), [len(one) for one in each])
        shine = np.bincount(which, np.exp(log), len(own))
        amount = np.log(peaks.area[chosen[own]]) - np.log(shine)
        share[spectrum] = _share(peaks.element[chosen[own]], amount)
    return share


def _share(element, log_amount: FloatArray) -> float:
    names = np.unique(element)
    middle = {str(name): float(np.median(log_amount[element == name])) for name in names}
    most = max(middle.values())
    parts = {name: float(np.exp(value - most)) for name, value in middle.items()}
    return parts.get("Li", 0.0) / sum(parts.values())


def _rows(peaks: Records, chosen: IntArray) -> tuple[IntArray, IntArray]:
    """Rows of the line table that make up each chosen peak, and which of these each belongs to."""
    a = atoms()
    number = {str(name): index for index, name in enumerate(a.elements)}
    found: dict[tuple[str, str, float], IntArray] = {}
    air = to_air(a.wavelength_nm)
    keys = [
        (str(peaks.element[i]), str(peaks.stage[i]), round(float(peaks.line_nm[i]), 2))
        for i in chosen
    ]
    votes = [_near(a, number, nm, key) for nm in (air, a.wavelength_nm) for key in set(keys)]
    half = len(votes) // 2
    in_air = sum(len(v) > 0 for v in votes[:half]) >= sum(len(v) > 0 for v in votes[half:])
    shown = air if in_air else a.wavelength_nm
    for key in keys:
        if key not in found:
            found[key] = _near(a, number, shown, key)
    lists = [found[key] for key in keys]
    entry = np.repeat(np.arange(len(keys)), [len(one) for one in lists])
    return np.concatenate(lists or [np.empty(0, np.int64)]), entry


def _near(a, number, shown_nm, key) -> IntArray:
    element, stage, nm = key
    if element not in number:
        return np.empty(0, np.int64)
    at = slice(*np.searchsorted(shown_nm, [nm - SAME_NM, nm + SAME_NM]))
    own = (a.element[at] == number[element]) & (a.ion[at] == (stage == "2"))
    return np.flatnonzero(own) + at.start
