"""The evidence for each element, in text and numbers that can be checked on the spectrum."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..peaks.voigt import VoigtPeaks
from ..plasma.strengths import atoms
from ..spectrum.spectrum import BoolArray, FloatArray
from .abundance_prior import COMPANY
from .evidence_score import best_entries
from .faint_lines import ENOUGH, explained
from .identify import Identified
from .index import CERTAIN, DETECTED, DETECTED_ALONE, UNCERTAIN

Status = Literal["detected", "uncertain", "absent"]
CONFOUNDS = 0.2  # part of a peak that another element may have, from which it is named
NAN = float("nan")
FEW, CLEAR = 3, 15.0  # a weight of less, on so few peaks, is held against the whole line table
ALONE = 15.0  # the weight of an element that hardly comes without others, and none of them is there
SINGLE = 8.0  # errors of its area that the only line of an element must have


@dataclass(frozen=True, slots=True)
class Evidence:
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
    claimed = _claims(identified, peaks)
    names = atoms().elements.tolist()
    first, matched = identified.catalogue.first, identified.matched
    best = best_entries(first, identified.effective, matched.peak)
    above = _above_chance(identified)
    score, place = identified.indexed.weight.tolist(), np.minimum(best, len(matched.limit) - 1)
    limit, line_nm = matched.limit[place].tolist(), matched.shown_nm[place].tolist()
    found = {}
    for e in np.flatnonzero(np.diff(first)).tolist():
        if score[e] < UNCERTAIN:
            found[names[e]] = Evidence(
                names[e], "absent", score[e], 0, 0, line_nm[e], 0.0, NAN, (), limit[e]
            )
        else:
            found[names[e]] = _of(identified, peaks, e, names[e], claimed, int(best[e]), above)
    return found


def _above_chance(identified: Identified) -> FloatArray:
    """The weights less what the same lines weigh where they are not, shape (e,)."""
    chance = identified.chance
    return identified.indexed.weight - (0.0 if chance is None else chance)


def _least(name: str, above: FloatArray, *, certain: bool) -> float:
    """The weight above chance from which an element is detected."""
    company = COMPANY.get(name)
    if company is not None:
        others = np.isin(atoms().elements, sorted(company - {name}))
        if not np.any(above[others] >= DETECTED):
            return ALONE
    return DETECTED if certain else DETECTED_ALONE


def _claims(identified: Identified, peaks: VoigtPeaks) -> tuple[list[str], BoolArray]:
    """The likely elements (l,), and which peaks each should have a good part of, (l, k)."""
    likely = np.flatnonzero(identified.indexed.weight > UNCERTAIN)
    good = np.zeros((len(likely), len(peaks)), dtype=np.bool_)
    least = CONFOUNDS * peaks.area
    for row, e in enumerate(likely.tolist()):
        entries = _entries(identified, e)
        which = identified.matched.peak[entries]
        seen = which >= 0
        area = np.exp(identified.effective[entries][seen] + identified.indexed.log_scale[e])
        good[row] = np.bincount(which[seen], area, len(peaks)) > least
    return atoms().elements[likely].tolist(), good


def _entries(identified: Identified, e: int) -> slice:
    return slice(identified.catalogue.first[e], identified.catalogue.first[e + 1])


def _of(
    identified: Identified, peaks: VoigtPeaks, e: int, name: str, claimed, best: int,
    above: FloatArray,
) -> Evidence:  # fmt: skip
    matched = identified.matched
    score = float(identified.indexed.weight[e])
    limit = float(matched.limit[best])
    entries = _entries(identified, e)
    expected = np.exp(identified.effective[entries] + identified.indexed.log_scale[e])
    shows = (expected > matched.limit[entries]) & (matched.peak[entries] > -3)
    due = entries.start + np.flatnonzero(shows)
    there = due[matched.peak[due] >= 0]
    line_nm, area, error = float(matched.shown_nm[best]), 0.0, NAN
    if len(there):
        top = there[np.argmax(peaks.area[matched.peak[there]])]
        k = matched.peak[top]
        line_nm, area = float(matched.shown_nm[top]), float(peaks.area[k])
        error = float(peaks.area_error[k])
    own = np.flatnonzero(np.bincount(matched.peak[there]))
    certain = float(identified.indexed.weight.max()) >= CERTAIN
    sure = float(above[e]) >= _least(name, above, certain=certain) and (
        len(own) > 1 or _stands_alone(identified, name, area, error)
    )
    if sure and len(own) <= FEW and score < CLEAR:
        own_alone = own[explained(identified, peaks, own, e) < ENOUGH]
        clear = peaks.area[own_alone] > SINGLE * peaks.area_error[own_alone]
        sure = len(own_alone) > 1 or bool(clear.any())
    status: Status = "detected" if sure else "uncertain"
    names, good = claimed
    rivals = tuple(
        names[row] for row in np.flatnonzero(good[:, own].any(axis=1)) if names[row] != name
    )
    return Evidence(name, status, score, len(there), len(due), line_nm, area, error,
                    rivals, limit)  # fmt: skip


def _stands_alone(identified: Identified, name: str, area: float, error: float) -> bool:
    """Whether a single line is enough: a strong one, or H-alpha with its width."""
    return area > SINGLE * error or (name == "H" and identified.hydrogen is not None)
