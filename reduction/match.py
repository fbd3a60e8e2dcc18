"""Put every expected line beside its peak, or say why there is none."""

from dataclasses import dataclass

import numpy as np

from .air import AIR_BEGINS_NM, INDEX_TERMS
from .kernel import float_kernel
from .offsets import Offsets
from .profiles import Profiles
from .spectrum import BoolArray, FloatArray, IntArray
from .voigt import SIGMA_PER_FWHM
from .weigh import BAD, IN_A_CROWD, NOT_SEEN

LIMIT_SIGMA = 3.0  # height in noise that a line must have to be expected
TOLERANCE = 3.2  # errors of the place
WIDER_THAN_SLIT = 1.15  # a line's area by its height and the slit's width
WIDEST_NM = 0.8  # broader lines go into the background in part
TOO_BROAD = 3.0  # times the width that the line should have
CROWD_NM = 6.0  # window in which peaks are counted, for what falls on one by chance
CELLS = 2_048  # of the axis: a place is looked up to a channel or two, enough for widths and limits
AREA_PER_BOX = 1.0645  # of a Gaussian


@dataclass(frozen=True, slots=True, eq=False)
class Matched:
    """Expected lines beside the peaks; arrays of one entry of the catalogue each.

    peak: index of the peak, or a reason why there is none (weigh.NOT_SEEN, IN_A_CROWD, BAD).
    away: distance in errors. limit: area in counts nm above which the line should be seen, and
    its ln. chance: of each peak, peaks that fall by chance on one error of the place, shape (k,).
    """

    shown_nm: FloatArray
    peak: IntArray
    away: FloatArray
    limit: FloatArray
    log_limit: FloatArray
    place_error_nm: float
    chance: FloatArray


def match_lines(
    profiles: Profiles,
    x: FloatArray,
    bad: BoolArray,
    offsets: Offsets,
    vacuum_nm: FloatArray,
    place_error_nm: float,
    stark_nm: FloatArray,
) -> Matched:
    """Put every expected line beside its peak. Peaks must ascend in their centres.

    x: nm; bad: channels that do not count; both (m,). vacuum_nm: where the lines are, and stark_nm:
    their full Stark widths, both (entries,): a broad one must be brighter to stand out.
    """
    peaks = profiles.peaks
    error = np.sqrt(np.maximum(peaks.covariance[:, 1, 1], 0.0))
    shown, which, away, limit = _match(
        vacuum_nm, stark_nm, offsets.medium == "air", offsets.edges_nm, offsets.offset_nm,
        x, profiles.slit.sigma_nm, profiles.noise, bad, place_error_nm,
        peaks.centre_nm, np.nan_to_num(error), peaks.fwhm_nm, peaks.area,
    )  # fmt: skip
    chance = crowding(peaks.centre_nm) * place_error_nm
    return Matched(shown, which, away, limit, np.log(limit), place_error_nm, chance)


def crowding(centre_nm: FloatArray) -> FloatArray:
    """Peaks per nm around each peak, shape (k,)."""
    half = 0.5 * CROWD_NM
    last = np.searchsorted(centre_nm, centre_nm + half)
    return np.maximum(last - np.searchsorted(centre_nm, centre_nm - half), 1.0) / CROWD_NM


@float_kernel
def in_air(vacuum_nm):
    """As air.to_air, of one wavelength."""
    if vacuum_nm < AIR_BEGINS_NM:
        return vacuum_nm
    squared = (1000.0 / vacuum_nm) ** 2
    a, b, c, d = INDEX_TERMS
    return vacuum_nm / (1.0 + a / (b - squared) + c / (d - squared))


@float_kernel
def places(x):
    """The channel, with fraction, at the edges of even cells from x[0] to x[-1]."""
    out = np.empty(CELLS + 1)
    n, k = len(x), 0
    for cell in range(CELLS + 1):
        at = x[0] + (x[n - 1] - x[0]) * cell / CELLS
        while k < n - 2 and x[k + 1] <= at:
            k += 1
        out[cell] = k + min((at - x[k]) / (x[k + 1] - x[k]), 1.0)
    return out


@float_kernel
def first_not_below(ascending, value):
    """As np.searchsorted."""
    low, high = 0, len(ascending)
    while low < high:
        middle = (low + high) >> 1
        if ascending[middle] < value:
            low = middle + 1
        else:
            high = middle
    return low


@float_kernel
def _match(
    vacuum_nm, stark_nm, air, edges_nm, offset_nm, x, sigma_nm, noise, bad, place_error,
    peak_nm, peak_error, peak_width, area,
):  # fmt: skip
    n, m = len(vacuum_nm), len(x)
    shown, away, limit = np.empty(n), np.zeros(n), np.empty(n)
    which = np.full(n, NOT_SEEN, np.int64)
    table = places(x)
    per_nm = CELLS / (x[m - 1] - x[0])
    for j in range(n):
        true = in_air(vacuum_nm[j]) if air else vacuum_nm[j]
        stretch = 0
        while stretch < len(edges_nm) and edges_nm[stretch] <= true:
            stretch += 1
        at = true + offset_nm[stretch]
        shown[j] = at
        cell = min(max((at - x[0]) * per_nm, 0.0), CELLS - 1e-9)
        k = int(cell)
        c = int(table[k] + (cell - k) * (table[k + 1] - table[k]) + 0.5)
        c = min(max(c, 1), m - 1)
        fwhm = WIDER_THAN_SLIT * max(sigma_nm[c] / SIGMA_PER_FWHM, 1.5 * (x[c] - x[c - 1]))
        # The width of a Voigt profile (Olivero and Longbothum, JQSRT 17, 233 (1977)).
        wide = 0.5346 * stark_nm[j] + np.sqrt(0.2166 * stark_nm[j] ** 2 + fwhm**2)
        limit[j] = LIMIT_SIGMA * noise[c] * AREA_PER_BOX * wide
        if wide > WIDEST_NM:
            limit[j] *= (wide / WIDEST_NM) ** 2
        if at < x[0] + fwhm or at > x[m - 1] - fwhm or bad[c] or bad[c - 1]:
            which[j] = BAD
            continue
        k = first_not_below(peak_nm, at)
        best = 1e9
        crowd = False
        for i in range(max(k - 2, 0), min(k + 2, len(peak_nm))):
            if peak_width[i] > TOO_BROAD * wide:
                continue
            distance = abs(peak_nm[i] - at)
            z = distance / np.sqrt(place_error**2 + min(peak_error[i], 0.3 * fwhm) ** 2)
            if z < best:
                best = z
                if z < TOLERANCE:
                    which[j], away[j] = i, z
            crowd = crowd or (distance < 1.5 * fwhm and area[i] > 2 * limit[j])
        if which[j] == NOT_SEEN and crowd:
            which[j] = IN_A_CROWD
    return shown, which, away, limit
