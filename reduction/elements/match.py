"""Match every expected line with its peak, or give the reason why there is none."""

from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from ..lines.air_kernel import in_air
from ..peaks.profiles import Profiles
from ..peaks.voigt import SIGMA_PER_FWHM
from ..spectrum.kernel import kernel
from ..spectrum.spectrum import BoolArray, FloatArray, IntArray
from .evidence_score import BAD, IN_A_CROWD, NOT_SEEN
from .offsets import Offsets

LIMIT_SIGMA = 3.0  # height in noise that a line must have to be expected
TOLERANCE = 3.2  # errors of the place
WIDER_THAN_SLIT = 1.15  # a line's area by its height and the slit's width
WIDEST_NM = 0.8  # broader lines go into the background in part
TOO_BROAD = 3.0  # times the width that the line should have
CROWD_NM = 6.0  # window in which peaks are counted, for what falls on one by chance
FAR = 4.0  # widths of the slit, beyond which no peak is looked at
# What hides one line (a detector that sees little there, a wrong offset) may hide its neighbours:
# in a stretch of the axis all missing lines together count no more than this, and in one without
# any peak less.
STRETCH_NM = 25.0
AGAINST, AGAINST_BLIND = -3.5, -1.0
AREA_PER_BOX = 1.0645  # of a Gaussian


@dataclass(frozen=True, slots=True, eq=False)
class Matched:
    """Expected lines beside the peaks; arrays of one entry of the catalogue each.

    peak: index of the peak, or a reason why there is none (NOT_SEEN, IN_A_CROWD, BAD).
    away: distance in errors. limit: area in counts nm above which the line should be seen, and
    its ln; log_hidden: ln of the area that the light at its place could hide. Of each peak, shape
    (k,): chance, peaks that fall by chance on one error of the place; area (counts nm), its ln, and
    its relative error, 1 at the most. stretch: of the axis, counted from 0, in which each entry is;
    against: what lines that are missing in a stretch say against an element, all of them together
    and at the most.
    """

    shown_nm: FloatArray
    peak: IntArray
    away: FloatArray
    limit: FloatArray
    log_limit: FloatArray
    log_hidden: FloatArray
    place_error_nm: float
    chance: FloatArray
    area: FloatArray
    log_peak: FloatArray
    relative: FloatArray
    stretch: IntArray
    against: FloatArray


class _Places(NamedTuple):
    """Of the lines, shape (entries,): where in vacuum and how wide, nm, and in which order."""

    vacuum_nm: FloatArray
    stark_nm: FloatArray
    order: IntArray


class _Axis(NamedTuple):
    """Of the channels, shape (m,): place and width of the slit in nm, noise and light above the
    background in counts, bad or not."""

    nm: FloatArray
    sigma_nm: FloatArray
    noise: FloatArray
    net: FloatArray
    bad: BoolArray


class _Peaks(NamedTuple):
    """Of the peaks, shape (k,): centre, its error and full width in nm; area in counts nm."""

    nm: FloatArray
    error: FloatArray
    width: FloatArray
    area: FloatArray


def match_lines(
    profiles: Profiles,
    x: FloatArray,
    bad: BoolArray,
    offsets: Offsets,
    vacuum_nm: FloatArray,
    place_error_nm: float,
    stark_nm: FloatArray,
    order: IntArray | None = None,
) -> Matched:
    """Match every expected line with its peak. Peaks must ascend in their centres.

    x: nm; bad: channels that do not count; both (m,). vacuum_nm: where the lines are, and stark_nm:
    their full Stark widths, both (entries,): a broad one must be brighter to stand out.
    order: in which the lines nearly ascend, which makes it quick.
    """
    order = np.argsort(vacuum_nm) if order is None else order
    seen = _seen(profiles)
    shown, which, away, limit, hidden, stretch = _match(
        _Places(vacuum_nm, stark_nm, order),
        _Axis(x, profiles.slit.sigma_nm, profiles.noise, profiles.net, bad),
        seen.peaks,
        offsets.medium == "air", offsets.edges_nm, offsets.offset_nm, place_error_nm,
    )  # fmt: skip
    return Matched(
        shown, which, away, limit, np.log(limit), np.log(hidden), place_error_nm,
        seen.crowding * place_error_nm, seen.area, seen.log_area, seen.relative, stretch,
        seen.against,
    )  # fmt: skip


class _Seen(NamedTuple):
    """What does not depend on where lines are expected; of the peaks, shape (k,), but for against."""

    peaks: _Peaks
    crowding: FloatArray
    area: FloatArray
    log_area: FloatArray
    relative: FloatArray
    against: FloatArray


@lru_cache(maxsize=8)  # for the rounds of one spectrum, and threads that reduce at once
def _seen(profiles: Profiles) -> _Seen:
    peaks = profiles.peaks
    error = np.sqrt(np.maximum(peaks.covariance[:, 1, 1], 0.0))
    error[np.isnan(error)] = 0.0
    area = np.maximum(peaks.area, 1e-12)
    return _Seen(
        _Peaks(peaks.centre_nm, error, peaks.fwhm_nm, peaks.area), crowding(peaks.centre_nm), area,
        np.log(area), np.fmin(peaks.area_error / area, 1.0),
        _against(peaks.centre_nm, profiles.wavelength_nm),
    )  # fmt: skip


def _against(centre_nm: FloatArray, x: FloatArray) -> FloatArray:
    """For each stretch; little where not a single peak shows that anything could be seen."""
    n = int((x[-1] - x[0]) / STRETCH_NM) + 1
    stretch = np.clip((centre_nm - x[0]) / STRETCH_NM, 0.0, n - 1.0).astype(np.int64)
    seen = np.bincount(stretch, minlength=n) > 0
    return np.where(seen, AGAINST, AGAINST_BLIND)


def crowding(centre_nm: FloatArray) -> FloatArray:
    """Peaks per nm around each peak, shape (k,)."""
    half = 0.5 * CROWD_NM
    last = np.searchsorted(centre_nm, centre_nm + half)
    return np.maximum(last - np.searchsorted(centre_nm, centre_nm - half), 1.0) / CROWD_NM


@kernel
def _match(places, axis, peaks, air, edges_nm, offset_nm, place_error):
    vacuum_nm, stark_nm, order = places
    x, sigma_nm, noise, net, bad = axis
    peak_nm, peak_error, peak_width, area = peaks
    n, m, n_peaks = len(vacuum_nm), len(x), len(peak_nm)
    shown, away, limit, hidden = np.empty(n), np.zeros(n), np.empty(n), np.empty(n)
    which, stretches = np.full(n, NOT_SEEN, np.int64), np.empty(n, np.int64)
    last = int((x[m - 1] - x[0]) / STRETCH_NM)
    c, k, stretch = 1, 0, 0  # channel, peak and offset of the line before: the next is near
    for j in order:
        true = in_air(vacuum_nm[j]) if air else vacuum_nm[j]
        while stretch < len(edges_nm) and edges_nm[stretch] <= true:
            stretch += 1
        while stretch > 0 and edges_nm[stretch - 1] > true:
            stretch -= 1
        at = true + offset_nm[stretch]
        shown[j], stretches[j] = at, min(int(max((at - x[0]) / STRETCH_NM, 0.0)), last)
        while c < m - 1 and x[c] < at:
            c += 1
        while c > 1 and x[c - 1] >= at:
            c -= 1
        fwhm = WIDER_THAN_SLIT * max(sigma_nm[c] / SIGMA_PER_FWHM, 1.5 * (x[c] - x[c - 1]))
        # The width of a Voigt profile (Olivero and Longbothum, JQSRT 17, 233 (1977)).
        wide = 0.5346 * stark_nm[j] + np.sqrt(0.2166 * stark_nm[j] ** 2 + fwhm**2)
        limit[j] = LIMIT_SIGMA * noise[c] * AREA_PER_BOX * wide
        if wide > WIDEST_NM:
            limit[j] *= (wide / WIDEST_NM) ** 2
        light = max(net[c - 1], net[c])
        hidden[j] = max(limit[j], light * AREA_PER_BOX * wide)
        if at < x[0] + fwhm or at > x[m - 1] - fwhm or bad[c] or bad[c - 1]:
            which[j] = BAD
            continue
        while k < n_peaks and peak_nm[k] < at:
            k += 1
        while k > 0 and peak_nm[k - 1] >= at:
            k -= 1
        best = TOLERANCE**2
        crowd = False
        for i in range(max(k - 2, 0), min(k + 2, n_peaks)):
            distance = abs(peak_nm[i] - at)
            if distance > FAR * fwhm or peak_width[i] > TOO_BROAD * wide:
                continue
            square = distance**2 / (place_error**2 + min(peak_error[i], 0.3 * fwhm) ** 2)
            if square < best:
                best, which[j] = square, i
            crowd = crowd or (distance < 1.5 * fwhm and area[i] > 2 * limit[j])
        if which[j] >= 0:
            away[j] = np.sqrt(best)
        elif crowd:
            which[j] = IN_A_CROWD
    return shown, which, away, limit, hidden, stretches
