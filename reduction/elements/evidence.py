"""The evidence for each element, in text and numbers that can be checked on the spectrum."""

from math import lgamma, log
from typing import Literal, NamedTuple

import numpy as np

from ..lines.lines import of_lines
from ..peaks.voigt import VoigtPeaks
from ..plasma.strengths import atoms
from ..spectrum.spectrum import BoolArray, FloatArray, IntArray
from .abundance_prior import COMPANY, log_odds
from .evidence_score import BAD, CANDIDATES, LOG_AREA_RANGE, best_entries
from .faint_lines import ENOUGH, explained
from .identify import FIRST_K, SECOND_SPREAD, Identified
from .index import CERTAIN, DETECTED, DETECTED_ALONE, UNCERTAIN
from .index import ENOUGH as KNOWN

Status = Literal["detected", "uncertain", "absent"]
CONFOUNDS = 0.2  # part of a peak that another element may have, from which it is named
NAN = float("nan")
FEW, CLEAR = 3, 15.0  # a weight of less, on so few peaks, is held against the whole line table
ALONE = 15.0  # the weight of an element that hardly comes without others, and none of them is there
SINGLE = 8.0  # errors of its area that the only line of an element must have
# Where hardly any light is explained, an element with as many lines due needs more of them to agree than
# any of all elements would find by chance. In place (errors) and in area (spreads):
MANY, IN_PLACE, IN_AREA = 20, 2.0, 1.5
TERMS = 60  # of the sum of Poisson's law


class Evidence(NamedTuple):
    """status by score (ln of the odds, prior included). Lines are those that should stand out.

    lines_matched of lines_expected have a peak. line_nm, area, area_error: the strongest matched
    line, as the instrument shows it (area 0, nan where no line is matched). confounders: elements
    that might have made the same peaks. detection_limit: area (counts nm) at which the element's
    best line would show at three times the noise.
    """

    element: str
    status: Status
    score: float
    lines_matched: int
    lines_expected: int
    line_nm: float
    area: float
    area_error: float
    confounders: tuple[str, ...]
    detection_limit: float


def evidence(identified: Identified, peaks: VoigtPeaks) -> dict[str, Evidence]:
    """Evidence of every element that has a line within the spectrum, by symbol."""
    due = _due(identified, peaks)
    names = atoms().elements.tolist()
    first, matched = identified.catalogue.first, identified.matched
    best = best_entries(first, identified.effective, matched.peak)
    above = _above_chance(identified)
    score, place = identified.indexed.weight.tolist(), np.minimum(best, len(matched.limit) - 1)
    limit, line_nm = matched.limit[place].tolist(), matched.shown_nm[place].tolist()
    certain = float(identified.indexed.weight.max()) >= CERTAIN
    found = {}
    for e in np.flatnonzero(np.diff(first)).tolist():
        if score[e] < UNCERTAIN:
            found[names[e]] = Evidence(
                names[e], "absent", score[e], 0, 0, line_nm[e], 0.0, NAN, (), limit[e]
            )
        else:
            found[names[e]] = _of(identified, peaks, e, names[e], due, int(best[e]), above, certain)
    return found


def _above_chance(identified: Identified) -> FloatArray:
    """The weights less what the same lines weigh where they are not, shape (e,)."""
    chance = identified.chance
    return identified.indexed.weight - (0.0 if chance is None else chance)


def _least(name: str, above: FloatArray, *, certain: bool) -> float:
    """The weight above chance from which an element is detected."""
    company = _company().get(name)
    if company is not None and not np.any(above[company] >= DETECTED):
        return ALONE
    return DETECTED if certain else DETECTED_ALONE


@of_lines()
def _company() -> dict[str, IntArray]:
    """The others that some elements hardly come without."""
    names = atoms().elements
    return {
        name: np.flatnonzero(np.isin(names, sorted(others - {name})))
        for name, others in COMPANY.items()
    }


class _Due(NamedTuple):
    """Of the elements that are likely: their names (l,), and which peaks each should have a good part of,
    (l, k). By element, its entries that should show, and those of them that have a peak."""

    names: list[str]
    good: BoolArray
    shows: dict[int, IntArray]
    there: dict[int, IntArray]


def _due(identified: Identified, peaks: VoigtPeaks) -> _Due:
    matched, spans = identified.matched, identified.catalogue.spans
    likely = np.flatnonzero(identified.indexed.weight >= UNCERTAIN)
    good = np.zeros((len(likely), len(peaks)), dtype=np.bool_)
    least = CONFOUNDS * peaks.area
    due: dict[int, IntArray] = {}
    there: dict[int, IntArray] = {}
    for row, e in enumerate(likely.tolist()):
        own = spans[e]
        which = matched.peak[own]
        seen = which >= 0
        area = _expected(identified, e)
        good[row] = np.bincount(which[seen], area[seen], len(peaks)) > least
        shows = _shows(identified, e, area)
        due[e], there[e] = own[shows], own[shows & seen]
    return _Due(atoms().elements[likely].tolist(), good, due, there)


def _expected(identified: Identified, e: int) -> FloatArray:
    """The areas of an element's lines."""
    own = identified.catalogue.spans[e]
    return np.exp(identified.effective[own] + identified.indexed.log_scale[e])


def _shows(identified: Identified, e: int, area: FloatArray) -> BoolArray:
    """Which of an element's lines should stand out."""
    own, matched = identified.catalogue.spans[e], identified.matched
    return (area > matched.limit[own]) & (matched.peak[own] > BAD)


def _of(
    identified: Identified, peaks: VoigtPeaks, e: int, name: str, due: _Due, best: int,
    above: FloatArray, certain: bool,
) -> Evidence:  # fmt: skip
    matched = identified.matched
    score = float(identified.indexed.weight[e])
    limit = float(matched.limit[best])
    shows = due.shows[e]
    which = matched.peak[due.there[e]]
    line_nm, area, error = float(matched.shown_nm[best]), 0.0, NAN
    if len(which):
        top = int(np.argmax(peaks.area[which]))
        k = which[top]
        line_nm, area = float(matched.shown_nm[due.there[e][top]]), float(peaks.area[k])
        error = float(peaks.area_error[k])
    own = np.array(sorted(set(which.tolist())), np.int64)
    sure = float(above[e]) >= _least(name, above, certain=certain) and (
        len(own) > 1 or _stands_alone(identified, name, area, error)
    )
    if sure and len(own) <= FEW and score < CLEAR:
        own_alone = own[explained(identified, peaks, own, e) < ENOUGH]
        clear = peaks.area[own_alone] > SINGLE * peaks.area_error[own_alone]
        sure = len(own_alone) > 1 or bool(clear.any())
    doubtful = sure and len(shows) >= MANY and log_odds()[e] < 0.0
    if doubtful and identified.indexed.explained(peaks.area) < KNOWN:
        sure = _against_chance(identified, peaks, shows, e) >= _tried() + DETECTED
    status: Status = "detected" if sure else "uncertain"
    claimed = np.any(due.good[:, own], axis=1).tolist()
    rivals = tuple(
        other for other, some in zip(due.names, claimed, strict=True) if some and other != name
    )
    return Evidence(name, status, score, len(which), len(shows), line_nm, area, error,
                    rivals, limit)  # fmt: skip


def beyond_chance(identified: Identified, peaks: VoigtPeaks) -> float:
    """ln of the odds that the accepted elements' lines agree with the peaks, against chance, all together."""
    each = []
    for e in identified.indexed.accepted:
        shows = _shows(identified, e, _expected(identified, e))
        due = identified.catalogue.spans[e][shows]
        each.append(_against_chance(identified, peaks, due, e) - _tried())
    return sum(max(said, 0.0) for said in each)


def _tried() -> float:
    """ln of how many elements, brightnesses and temperatures chance had."""
    return log(len(atoms().elements) * CANDIDATES * len(FIRST_K))


def _against_chance(identified: Identified, peaks: VoigtPeaks, due: IntArray, e: int) -> float:
    """-ln of the odds that as many of an element's lines agree in place and area by chance, at least 0.

    due: entries that should show. One line that agrees says nothing: it told how bright the element is.
    The others fall on peaks as Poisson's law says, as densely as peaks lie around them.
    """
    matched, peak = identified.matched, identified.matched.peak[due]
    spread = np.hypot(SECOND_SPREAD, identified.catalogue.uncertainty[due])
    expected = identified.effective[due] + identified.indexed.log_scale[e]
    agrees = (peak >= 0) & (matched.away[due] < IN_PLACE)
    agrees &= np.abs(matched.log_peak[peak] - expected) < IN_AREA * spread
    beside = np.searchsorted(peaks.centre_nm, matched.shown_nm[due])
    chance = matched.chance[np.minimum(beside, len(peaks) - 1)] * 2 * IN_PLACE
    by_chance = chance * np.minimum(2 * IN_AREA * spread / LOG_AREA_RANGE, 1.0)
    return _above(len(np.unique(peak[agrees])) - 1, float(np.minimum(by_chance, 1.0).sum()))


def _above(number: int, mean: float) -> float:
    """-ln of how likely so many or more are, of Poisson's law."""
    if number <= 0:
        return 0.0
    first = number * log(mean) - mean - lgamma(number + 1)
    part = more = 1.0
    for k in range(number + 1, number + TERMS):
        part *= mean / k
        more += part
    return max(-first - log(more), 0.0)


def _stands_alone(identified: Identified, name: str, area: float, error: float) -> bool:
    """Whether a single line is enough: a strong one, or H-alpha with its width."""
    return area > SINGLE * error or (name == "H" and identified.hydrogen is not None)
