"""Say which elements a spectrum shows: weigh each, believe the surest, take its lines away, go on."""

from dataclasses import dataclass

import numpy as np

from .catalogue import Catalogue, Expected
from .commonness import log_odds
from .offsets import Offsets
from .profiles import Profiles
from .spectrum import BoolArray, FloatArray, IntArray
from .strengths import atoms
from .voigt import SIGMA_PER_FWHM
from .weigh import match, weigh, weigh_all

LIMIT_SIGMA = 3.0  # height in noise that a line must have to be expected
TOLERANCE = 3.2  # errors of the place
WIDER_THAN_SLIT = 1.15  # a line's area by its height and the slit's width
DETECTED, UNCERTAIN = 5.5, 3.0  # weights, prior included
MODEL_SPREAD = 0.35  # of ln(area): temperature, self-absorption, calibration
CHANCE_WINDOW_NM = 6.0
WIDEST_NM = 0.8  # broader lines go into the background in part
COARSE = 16  # channels between the places that are looked up


@dataclass(frozen=True, slots=True, eq=False)
class Matched:
    """Expected lines beside the peaks; arrays of one entry of the catalogue each.

    peak: index of the peak, or a reason why there is none (weigh.NOT_SEEN, IN_A_CROWD, BAD).
    away: distance in errors. limit: area in counts nm above which the line should be seen.
    """

    shown_nm: FloatArray
    peak: IntArray
    away: FloatArray
    limit: FloatArray
    place_error_nm: float


@dataclass(frozen=True, slots=True, eq=False)
class Indexed:
    """weight and log_scale of each element (ln of atoms, arbitrary unit), shape (e,).

    accepted: indices of elements, surest first. taken: area of each peak that they explain.
    total: sum of the accepted weights.
    """

    weight: FloatArray
    log_scale: FloatArray
    accepted: list[int]
    taken: FloatArray
    total: float


def match_lines(
    profiles: Profiles,
    x: FloatArray,
    bad: BoolArray,
    offsets: Offsets,
    expected: Expected,
    place_error_nm: float,
    stark_nm: FloatArray,
) -> Matched:
    """Put every expected line beside its peak. Peaks must ascend in their centres.

    stark_nm: full Stark width of each line: a broad one must be brighter to stand out.
    """
    peaks = profiles.peaks
    shown = offsets.shown(expected.vacuum_nm)
    channel = _channels(x, shown)
    fwhm = profiles.slit.sigma_nm[channel] / SIGMA_PER_FWHM
    fwhm = np.maximum(fwhm, 1.5 * (x[channel] - x[channel - 1])) * WIDER_THAN_SLIT
    # The width of a Voigt profile (Olivero and Longbothum, JQSRT 17, 233 (1977)).
    wide = 0.5346 * stark_nm + np.sqrt(0.2166 * stark_nm**2 + fwhm**2)
    limit = LIMIT_SIGMA * profiles.noise[channel] * 1.0645 * wide
    limit = np.where(wide > WIDEST_NM, limit * (wide / WIDEST_NM) ** 2, limit)
    outside = (shown < x[0] + fwhm) | (shown > x[-1] - fwhm)
    spoiled = outside | bad[channel] | bad[channel - 1]
    error = np.sqrt(np.maximum(peaks.covariance[:, 1, 1], 0.0))
    which, away = match(
        shown, place_error_nm, peaks.centre_nm, np.nan_to_num(error), peaks.fwhm_nm, TOLERANCE,
        fwhm, wide, spoiled, peaks.area, limit,
    )  # fmt: skip
    return Matched(shown, which, away, limit, place_error_nm)


def _channels(x: FloatArray, shown_nm: FloatArray) -> IntArray:
    """The channel of each place to one or two: enough for widths and limits, and quick."""
    coarse = np.append(np.arange(0, len(x) - 1, COARSE), len(x) - 1)
    order = np.argsort(shown_nm)  # in order, a look-up finds its neighbour's place still at hand
    place = np.empty(len(shown_nm))
    place[order] = np.interp(shown_nm[order], x[coarse], coarse)
    return np.clip(np.rint(place).astype(np.int64), 1, len(x) - 1)


def index_peaks(
    profiles: Profiles,
    catalogue: Catalogue,
    log_area: FloatArray,
    matched: Matched,
    model_spread: float = MODEL_SPREAD,
    least: float = UNCERTAIN,
    rough: bool = False,
    bonus: FloatArray | float = 0.0,
) -> Indexed:
    """Weigh all elements and accept, one after the other, those above `least`.

    bonus: added to the weights, for evidence from elsewhere, shape (e,).
    rough: weigh each by itself only, as if no other element claimed its peaks; quicker.
    """
    a = atoms()
    peaks = profiles.peaks
    area = np.maximum(peaks.area, 1e-12)
    relative = np.clip(np.nan_to_num(peaks.area_error / area, nan=1.0), 0.0, 1.0)
    spread = np.sqrt(model_spread**2 + a.uncertainty[catalogue.leader] ** 2)
    low_ev = a.e_i_ev[catalogue.leader]
    chance = _density(peaks.centre_nm) * matched.place_error_nm
    taken = np.zeros(len(area))
    log_peak, log_limit = np.log(area), np.log(matched.limit)
    log_free = log_peak.copy()
    prior = log_odds() + bonus
    n = len(a.elements)

    def look(e: int) -> None:
        weight[e], scale[e] = weigh(
            catalogue.first[e], catalogue.first[e + 1], log_area, low_ev, spread, matched.peak,
            matched.away, log_limit, chance, log_peak, log_free, relative,
        )  # fmt: skip
        weight[e] += prior[e]

    weight, scale = weigh_all(
        catalogue.first, log_area, low_ev, spread, matched.peak, matched.away, log_limit, chance,
        log_peak, log_free, relative,
    )  # fmt: skip
    weight += prior
    if rough:
        likely = np.flatnonzero(weight > least)
        return Indexed(weight, scale, likely.tolist(), taken, float(weight[likely].sum()))
    fresh = np.ones(n, dtype=bool)
    open_ = np.ones(n, dtype=bool)
    accepted: list[int] = []
    total = 0.0
    while True:
        e = int(np.argmax(np.where(open_, weight, -np.inf)))
        if weight[e] < least:
            break
        if not fresh[e]:
            look(e)
            fresh[e] = True
            continue
        accepted.append(e)
        open_[e] = False
        total += weight[e]
        _take(catalogue, e, scale[e], log_area, spread, matched, area, taken)
        log_free[:] = np.log(np.maximum(area - taken, 1e-6 * area))
        fresh[:] = False
    for e in np.flatnonzero(open_ & ~fresh & (weight > 0.5 * least)):
        look(int(e))
    return Indexed(weight, scale, accepted, taken, total)


def _take(catalogue, e, scale, log_area, spread, matched, area, taken) -> None:
    """Give the element what it explains of each peak: all of it where the areas agree."""
    entries = np.arange(catalogue.first[e], catalogue.first[e + 1])
    entries = entries[matched.peak[entries] >= 0]
    expected = np.exp(log_area[entries] + scale)
    peak = matched.peak[entries]
    entries, peak, expected = (v[expected > 0.05 * area[peak]] for v in (entries, peak, expected))
    agrees = np.log(area[peak] / expected) < 2.0 * spread[entries]
    np.add.at(taken, peak, np.where(agrees, area[peak], expected))
    np.minimum(taken, area, out=taken)


def _density(centre_nm: FloatArray) -> FloatArray:
    """Peaks per nm around each peak, shape (k,)."""
    half = 0.5 * CHANCE_WINDOW_NM
    near = np.searchsorted(centre_nm, centre_nm + half) - np.searchsorted(
        centre_nm, centre_nm - half
    )
    return np.maximum(near, 1.0) / CHANCE_WINDOW_NM
