"""Identify the peaks in rounds: offsets, elements, plasma, then again with the results.

The first round has no prior knowledge and tries three temperatures; the second uses the true
positions of the found elements' lines, with their strengths at the plasma's temperature.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from ..lines.lines import of_lines
from ..peaks.profiles import Profiles
from ..peaks.voigt import VoigtPeaks
from ..plasma.boltzmann import Bend, Known, Plot, PlotLines, fit_plot
from ..plasma.growth import log_depth_of_unit, log_kept
from ..plasma.response import (
    DOUBTFUL,
    LEVEL,
    LOOSE,
    OPEN,
    STEPPED,
    Response,
    Usual,
    knots,
    stiffness,
)
from ..plasma.strengths import atoms
from ..spectrum.curve import median, usual_pitch_nm
from ..spectrum.spectrum import BoolArray, FloatArray, Medium
from .abundance_prior import log_odds
from .by_chance import by_chance
from .catalogue import CONDITIONS, Catalogue, Expected, catalogue
from .evidence_score import NOT_SEEN
from .gain_steps import gain_steps
from .hydrogen import H_ALPHA_NM, HAlpha, h_alpha
from .index import Alone, Indexed, index_peaks, weigh_alone
from .match import Matched, match_lines
from .offsets import Offsets, estimate_offsets, seams
from .plot_lines import lines_of_entries, plot_lines
from .response import Missing, find_response
from .steps_by_lines import steps_by_lines

FIRST_K = (8_500.0, 10_500.0, 13_000.0)
FIRST_DENSITY = 1e17
FIRST_STARK = 6e16  # of the widths that are expected before the density is known
FIRST_ERROR_NM, SECOND_ERROR_NM = 0.02, 0.008
FIRST_SPREAD, SECOND_SPREAD = 0.35, 0.3
SIGMA_STEP = 50  # channels: the slit's width changes slowly
SHIFTED = 0.08  # of a line's width, by which lines are displaced
STILL_SHIFTED = 0.06
STRONG, SPEAKING, LEAST_SPEAKING = 15.0, 6, 4  # errors of an area; lines of an element; in all
ANY = 5.0  # residual in ln(area) that an unknown response may make
EXPLAINED, NEARLY_ALL = 0.95, 0.96  # chi2, and part of the lines, that need no response
MISFIT, MISFIT_FROM = 0.5, 1.0  # of ln(area), for each root of the chi2 that is too much
VOTING = 15  # lines of an element that vote for the offset at first
STEPS = 10
# Part of their light that thicker lines lost, below which the last plot, which tells T and changes no
# element, is fitted from an optical depth of THICKEST on, too: some thick plasmas' fits ended with none, too
# hot by a fifth.
THIN, THICKEST = 0.02, 20.0
MISSING_BY = 0.6  # of ln(area), that a line may be above its limit and not seen
ROUGH_STEPS = 5  # of the first plot: the second goes on from there
H_ALPHA_SAYS = 5.0  # no other line of its neighbourhood is half as broad
MOVED_NM = 0.02  # of H-alpha, from which it is fitted again
HOPELESS = 0.75  # of the votes for the other medium: not worth a round
VOTES_COUNT = 2.0  # weight of the votes beside the weight of the elements, where they disagree
RARE = -4.0  # log odds below which an element has no vote at first
BLUR_NM = 0.015
BLURRED = 0.05
FEW, LOW_VOTE = 4, 0.4
FINE_STRETCH_NM, FINE_BLUR_NM = 18.0, 0.010
CHANNELS_OFF = 0.25  # part of a channel by which places differ however well all is known


@dataclass(frozen=True, slots=True, eq=False)
class Identified:
    """The identified peaks and the plasma.

    expected: at the plasma's temperature. effective: ln of the area for one atom, self-absorption
    and the instrument's response counted. plot: None where the lines do not tell. lines: those of
    the plot, its response taken off. response: None where a level one explains the lines. bend: what the
    plot knew of the response. chance: see `by_chance`, (e,).
    """

    catalogue: Catalogue
    expected: Expected
    effective: FloatArray
    offsets: Offsets
    matched: Matched
    indexed: Indexed
    plot: Plot | None
    hydrogen: HAlpha | None
    lines: PlotLines | None = None
    response: Response | None = None
    chance: FloatArray | None = None
    bend: Bend | None = None


def identify(
    x: FloatArray,
    bad: BoolArray,
    profiles: Profiles,
    medium: Medium | None = None,
) -> Identified | None:
    """Identify the peaks of a spectrum; None if it has no peak, or no line in its range.

    x: nm; bad: channels that do not count; both (m,). medium None: it is decided.
    """
    if not len(profiles.peaks):
        return None
    peaks = profiles.peaks
    known = catalogue(*_range(x), _apart(profiles))
    if not known.first[-1]:  # the line table has nothing here
        return None
    tries = _tries(known)
    first = tries[1]
    pitch_nm = usual_pitch_nm(x)
    wide_nm = float(median(peaks.fwhm_nm))
    error = max(FIRST_ERROR_NM, CHANNELS_OFF * pitch_nm, SHIFTED * wide_nm)
    rounds = []
    seams_nm = of_axis_nm = seams(x)
    best = None
    for offsets in _first_offsets(profiles, known, first, medium, seams_nm):
        if rounds and offsets.votes < HOPELESS * rounds[0][2].votes:
            break
        matched = match_lines(
            profiles,
            x,
            bad,
            offsets,
            first.vacuum_nm,
            error,
            stark(known, FIRST_STARK),
            known.order,
        )
        alone = None
        if best is None:
            best, alone = _likeliest(known, tries, matched)
        indexed = index_peaks(known, tries[best].log_area, matched, FIRST_SPREAD, alone=alone)
        rounds.append(
            (indexed.total + VOTES_COUNT * offsets.votes, best, offsets, matched, indexed)
        )
    _, best, offsets, matched, indexed = max(rounds, key=lambda found: found[0])
    expected, start_k = tries[best], FIRST_K[best]
    if not indexed.accepted:
        return Identified(known, expected, expected.log_area, offsets, matched, indexed, None, None)
    hydrogen = h_alpha(x, profiles.counts, profiles, offsets)
    density = known_density(hydrogen)
    lines = plot_lines(peaks, known, expected.log_area, matched, indexed)
    level = _level_bend(_range(x), tuple(seams_nm.tolist()))
    plot = fit_plot(lines, density, start_k, ROUGH_STEPS, level)
    gain, response, loose = np.zeros(len(expected.log_area)), None, level
    every = plot_lines(peaks, known, expected.log_area, matched, indexed, beyond=ANY)
    # A plot that was made without a response explains what there is.
    fits = plot is not None and plot.chi2 < EXPLAINED and len(lines) > NEARLY_ALL * len(every)
    stepped = not len(seams_nm)
    if stepped:
        seams_nm = gain_steps(x, profiles.counts)
        if plot is not None:
            loose = _level_bend(_range(x), tuple(seams_nm.tolist()), LOOSE)
            seams_nm = np.sort(np.append(seams_nm, steps_by_lines(every, plot, loose)[0]))
        stepped = len(seams_nm) > 0
    if stepped or not fits:
        loose = _level_bend(_range(x), tuple(seams_nm.tolist()), LOOSE)
        response = _response(every, known, expected, matched, indexed, loose)
        if response is None:  # no response that pays for its knots, and yet it may not be level
            level = _level_bend(
                _range(x), tuple(seams_nm.tolist()), STEPPED if fits else DOUBTFUL
            )  # fmt: skip
    if response is not None:
        gain = response.at(expected.vacuum_nm)
        lines = plot_lines(peaks, known, expected.log_area, matched, indexed, gain)
        missing = missing_lines(known, expected, matched, indexed)
        loose = replace(loose, start=response.log_gain)
        plot = fit_plot(lines, density, start_k, ROUGH_STEPS, loose, missing)
        response = response if plot is None else plot.response

    effective = expected.log_area
    before, hydrogen_at = offsets, offsets.place(H_ALPHA_NM)
    least = max(SECOND_ERROR_NM, CHANNELS_OFF / 2 * pitch_nm, STILL_SHIFTED * wide_nm)
    bonus = _from_h_alpha(hydrogen)
    widths, unsure, bend = stark(known, FIRST_STARK), gain, level
    for last in (False, True) if response is not None else (True,):
        offsets = _second_offsets(profiles, known, expected, indexed, before, of_axis_nm)
        expected = _expected(known, plot, expected)
        gain = np.zeros(len(expected.log_area))
        if response is not None:
            gain = response.at(expected.vacuum_nm)
        effective = _effective(known, expected, plot)
        off = scatter_nm(offsets, peaks, known, expected, indexed, 3 * error)
        second = min(max(least, off), 1.5 * error)
        log10_ne = np.log10(FIRST_STARK) if plot is None else plot.log10_ne
        widths = stark(known, 10**log10_ne)
        matched = match_lines(
            profiles, x, bad, offsets, expected.vacuum_nm, second, widths, known.order
        )  # fmt: skip
        unsure = _unsure(plot, response, expected.vacuum_nm)
        indexed = index_peaks(
            known, effective + gain, matched, SECOND_SPREAD, bonus=bonus, unsure=unsure
        )  # fmt: skip
        if not indexed.accepted:
            break
        lines = plot_lines(peaks, known, effective, matched, indexed, gain)
        if abs(offsets.place(H_ALPHA_NM) - hydrogen_at) > MOVED_NM:
            hydrogen = h_alpha(x, profiles.counts, profiles, offsets)
            hydrogen_at = offsets.place(H_ALPHA_NM)
        bend = level if response is None else replace(loose, start=response.log_gain)
        missing = missing_lines(known, expected, matched, indexed)
        free = bend
        if last and response is not None:
            free = replace(bend, stiff=stiffness(bend.knots_nm, seams_nm, OPEN))
        kelvin = plot.temperature_k if plot else start_k
        given = lines, known_density(hydrogen), kelvin, STEPS, free, missing, last
        plot = fit_plot(*given)
        if last and plot is not None and plot.lost < THIN:
            thick = fit_plot(*given, thickest=THICKEST)
            plot = plot if thick is None or thick.chi2 > plot.chi2 else thick
        if response is not None and plot is not None:
            response = plot.response
        if response is not None and not last and plot is not None:
            every = plot_lines(peaks, known, effective, matched, indexed, gain, ANY)
            more, rise = steps_by_lines(every, plot, bend)
            if len(more):
                seams_nm = np.sort(np.append(seams_nm, more))
                loose = _level_bend(_range(x), tuple(seams_nm.tolist()), LOOSE)
                at = loose.knots_nm
                start = response.at(at) + (at[:, None] > more) @ rise
                response = Response(at, start, response.error_at(at))
    if plot is not None and plot.response is not None:
        by = plot.response.at(lines.vacuum_nm)
        lines = replace(lines, log_area=lines.log_area - by)
    chance = by_chance(
        known, expected, effective + gain, matched, indexed, profiles, bad, offsets, widths, unsure,
        SECOND_SPREAD,
    )  # fmt: skip
    return Identified(
        known, expected, effective + gain, offsets, matched, indexed, plot, hydrogen, lines, response,
        chance, bend,
    )  # fmt: skip


@lru_cache(maxsize=16)
def _level_bend(
    range_nm: tuple[float, float], seams_nm: tuple[float, ...], usual: Usual = LEVEL
) -> Bend:
    at = knots(range_nm, np.array(seams_nm))
    return Bend(at, np.zeros(len(at)), stiffness(at, np.array(seams_nm), usual))


def _gone(known: Catalogue, expected: Expected, matched: Matched, indexed: Indexed):
    """Entries of accepted elements that should show and do not, and ln(area) above the limit."""
    entries = known.entries_of(indexed.accepted)
    above = expected.log_area[entries] - matched.log_limit[entries]
    bright = above + indexed.log_scale[known.element[entries]] > 0.5
    gone = bright & (matched.peak[entries] == NOT_SEEN)
    return entries[gone], above[gone]


def missing_lines(known: Catalogue, expected: Expected, matched: Matched, indexed: Indexed):
    entries, _ = _gone(known, expected, matched, indexed)
    if not len(entries):
        return None
    limit = matched.log_hidden[entries]
    return lines_of_entries(known, entries, limit, np.full(len(entries), MISSING_BY))


def _unsure(plot: Plot | None, response: Response | None, vacuum_nm: FloatArray) -> FloatArray:
    """Spread of ln(area) that the model of the plasma lacks, by its own misfit, (entries,)."""
    misfit = 0.0
    if plot is not None:
        misfit = MISFIT * float(np.sqrt(max(plot.chi2 - MISFIT_FROM, 0.0)))
    if response is None:
        return np.full(len(vacuum_nm), misfit)
    return np.sqrt(misfit**2 + response.error_at(vacuum_nm) ** 2)


def _response(
    lines: PlotLines, known: Catalogue, expected: Expected, matched: Matched, indexed: Indexed,
    bend: Bend,
) -> Response | None:  # fmt: skip
    """What the response is off by, from the lines of the accepted elements; None if it is level."""
    entries, above = _gone(known, expected, matched, indexed)
    missing = Missing(known.element[entries], expected.vacuum_nm[entries], above)
    found = find_response(lines, missing, CONDITIONS, bend)
    return None if found is None else found[0]


def scatter_nm(
    offsets: Offsets,
    peaks: VoigtPeaks,
    known: Catalogue,
    expected: Expected,
    indexed: Indexed,
    reach_nm: float,
) -> float:
    """How far strong peaks of the accepted elements are from where they should be, nm, one sigma.

    Stark shifts and self-absorption move lines by a tenth of their width, each by its own amount.
    """
    entries = np.concatenate([known.spans[e][:SPEAKING] for e in indexed.accepted])
    shown = offsets.shown(expected.vacuum_nm[entries])
    strong = np.flatnonzero(peaks.area > STRONG * peaks.area_error)
    if not len(strong):
        return 0.0
    away = np.abs(peaks.centre_nm[strong] - shown[:, None]).min(axis=1)
    away = away[away < reach_nm]
    if len(away) < LEAST_SPEAKING:
        return 0.0
    return 1.4826 * float(median(away))


def _likeliest(known: Catalogue, tries: list[Expected], matched: Matched) -> tuple[int, Alone]:
    """The initial temperature that explains most, and the elements weighed there."""
    first = weigh_alone(known, tries[0].log_area, matched, FIRST_SPREAD)
    each = [first, *(first.at(known, e.log_area, matched) for e in tries[1:])]
    best = int(np.argmax([alone.likelihood() for alone in each]))
    return best, each[best]


@of_lines(16)
def _tries(known: Catalogue) -> list[Expected]:
    """Expected lines at each of the initial temperatures."""
    return [known.strengths(t, FIRST_DENSITY) for t in FIRST_K]


def stark(known: Catalogue, density_per_cm3: float) -> FloatArray:
    """Full Stark width of each entry's leader, nm."""
    return known.width_nm * (density_per_cm3 / 1e17)


def _range(x: FloatArray) -> tuple[float, float]:
    return round(float(x[0]), 1), round(float(x[-1]), 1)


def _apart(profiles: Profiles) -> float:
    """Lines nearer than this are one to the instrument, nm; in steps, so that tables are reused."""
    sigma = float(median(profiles.slit.sigma_nm[::SIGMA_STEP].copy()))
    return float(np.round(np.exp(np.round(np.log(sigma) * 4) / 4), 4))


def _from_h_alpha(hydrogen: HAlpha | None) -> FloatArray:
    """The weight that a broad line at the right position adds to hydrogen, shape (e,)."""
    bonus = np.zeros(len(atoms().elements))
    if hydrogen is not None:
        bonus[atoms().elements == "H"] = H_ALPHA_SAYS
    return bonus


def known_density(hydrogen: HAlpha | None) -> Known | None:
    if hydrogen is None:
        return None
    return Known(hydrogen.log10_ne * np.log(10), hydrogen.log10_ne_error * np.log(10))


def _first_offsets(
    profiles, known: Catalogue, expected: Expected, medium, seams_nm
) -> list[Offsets]:
    vacuum_nm, weight = _first_votes(known, expected)
    return estimate_offsets(
        profiles.peaks.centre_nm, _say(profiles), vacuum_nm, weight, medium, _blur(profiles, BLUR_NM),
        seams_nm=seams_nm,
    )  # fmt: skip


@of_lines(16)
def _first_votes(known: Catalogue, expected: Expected) -> tuple[FloatArray, FloatArray]:
    """Positions and weights of the lines that vote before anything is known."""
    odds = log_odds()
    spans = list(zip(known.first[:-1], known.first[1:], strict=True))
    voting = [
        (e, a, min(b, a + VOTING)) for e, (a, b) in enumerate(spans) if odds[e] > RARE and b > a
    ]
    if not voting:  # a window without a line of any common element
        return np.empty(0), np.empty(0)
    entries = np.concatenate([np.arange(a, b) for _, a, b in voting])
    weight = np.concatenate([
        np.exp(0.3 * (expected.log_area[a:b] - expected.log_area[a:b].max()) + 0.35 * odds[e])
        for e, a, b in voting
    ])  # fmt: skip
    return expected.vacuum_nm[entries], weight


def _blur(profiles: Profiles, least_nm: float) -> float:
    """How well places are known for a vote, nm."""
    return max(least_nm, BLURRED * float(median(profiles.peaks.fwhm_nm)))


def _say(profiles: Profiles) -> FloatArray:
    peaks = profiles.peaks
    return np.log1p(np.maximum(peaks.area, 0.0) / np.maximum(peaks.area_error, 1e-12)) / 3.0


def _second_offsets(
    profiles, known, expected, indexed: Indexed, before: Offsets, seams_nm
) -> Offsets:
    """Only lines of the elements that were found vote, by how bright they should be."""
    entries = known.entries_of(indexed.accepted)
    bright = expected.log_area[entries] + indexed.log_scale[known.element[entries]]
    faintest = np.log(max(float(np.min(profiles.peaks.area)), 1e-9))
    weight = np.clip((bright - faintest) / 3.0, 0.0, 2.0)
    others, low = _everyday(known, expected, indexed)
    entries, weight = np.concatenate([entries, others]), np.concatenate([weight, low])
    voting = weight > 0
    peaks = profiles.peaks
    return estimate_offsets(
        peaks.centre_nm, _say(profiles), expected.vacuum_nm[entries[voting]], weight[voting],
        before.medium, _blur(profiles, FINE_BLUR_NM), FINE_STRETCH_NM, seams_nm,
    )[0]  # fmt: skip


def _everyday(known: Catalogue, expected: Expected, indexed: Indexed):
    """The strongest lines of common elements that were not found: a segment may hide them."""
    others = [e for e in np.flatnonzero(log_odds() == 0.0) if e not in indexed.accepted]
    entries = np.concatenate([known.spans[e][:FEW] for e in others] or [np.empty(0, np.int64)])
    return entries, np.full(len(entries), LOW_VOTE)


def _expected(known: Catalogue, plot: Plot | None, before: Expected) -> Expected:
    if plot is None:
        return before
    return known.strengths(plot.temperature_k, 10**plot.log10_ne)


def _effective(known: Catalogue, expected: Expected, plot: Plot | None) -> FloatArray:
    """ln area for one atom, each line weakened by what it absorbs where the amount is known."""
    if plot is None:
        return expected.log_area
    area = expected.log_area.copy()
    scale = plot.log_scale[known.element]
    its = np.flatnonzero(~np.isnan(scale))
    width = known.width_nm[its] * 10 ** (plot.log10_ne - 17)
    depth = log_depth_of_unit(expected.vacuum_nm[its], width, plot.temperature_k)
    area[its] += log_kept(plot.log_opacity + area[its] + scale[its] + depth)
    return area
