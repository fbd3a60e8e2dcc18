"""Find the elements in a spectrum: weigh all, accept the most certain, remove its lines, repeat."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..spectrum.spectrum import FloatArray
from .abundance_prior import log_odds
from .catalogue import Catalogue
from .evidence_score import MISSING_SPREAD, Lines, Peaks, accept, evidence_scores
from .match import Matched

UNCERTAIN = 2.0  # weight, prior included
# Where one element is certain, lines are what the peaks are; where none is, they may be anything.
CERTAIN, DETECTED, DETECTED_ALONE = 10.0, 2.5, 5.5
# Peaks, and the part of their light that is explained on an axis that is right.
STRONGEST, ENOUGH = 25, 0.3
MODEL_SPREAD = 0.35  # of ln(area): temperature, self-absorption, calibration


@dataclass(frozen=True, slots=True, eq=False)
class Indexed:
    """weight and log_scale of each element (ln of atoms, arbitrary unit), shape (e,).

    accepted: indices of elements, most certain first. taken: area of each peak that they explain.
    total: sum of the accepted weights.
    """

    weight: FloatArray
    log_scale: FloatArray
    accepted: list[int]
    taken: FloatArray
    total: float

    def explained(self, area: FloatArray) -> float:
        """The part of the strongest peaks' light that the accepted elements explain; area: (k,)."""
        bright = np.argsort(-area)[:STRONGEST]
        taken = np.clip(self.taken[bright], 0.0, area[bright])
        return float(taken.sum() / max(area[bright].sum(), 1e-300))


def index_peaks(
    catalogue: Catalogue,
    log_area: FloatArray,
    matched: Matched,
    model_spread: float = MODEL_SPREAD,
    least: float = UNCERTAIN,
    bonus: FloatArray | float = 0.0,
    unsure: FloatArray | float = 0.0,
    alone: "Alone | None" = None,
) -> Indexed:
    """Weigh all elements and accept, one after the other, those above `least`.

    log_area: ln of the area that each entry should have for one atom, shape (entries,). bonus:
    added to the weights, for evidence from elsewhere, shape (e,). unsure: spread of ln(area) that
    the instrument's response adds, (entries,). alone: what `weigh_alone` made of the same.
    """
    prior = log_odds() + bonus
    one = alone or weigh_alone(catalogue, log_area, matched, model_spread, unsure)
    weight, scale, accepted, taken = accept(
        catalogue.first, one.lines, one.peaks, matched.area, prior, least, one.weight.copy(),
        one.scale.copy(),
    )  # fmt: skip
    total = float(weight[accepted].sum())
    return Indexed(weight, scale, accepted.tolist(), taken, total)


class Alone(NamedTuple):
    """Each element weighed by itself, as if no other claimed its peaks: weight without a prior and ln of
    its brightness, (e,), and what was weighed."""

    lines: Lines
    peaks: Peaks
    weight: FloatArray
    scale: FloatArray

    def at(self, catalogue: Catalogue, log_area: FloatArray, matched: Matched) -> "Alone":
        """The same with other expected areas."""
        lines = self.lines._replace(log_area=log_area)
        scores = evidence_scores(catalogue.first, lines, self.peaks, matched.log_peak)
        return Alone(lines, self.peaks, *scores)

    def likelihood(self, least: float = UNCERTAIN) -> float:
        """Sum of the weights above `least`, prior included."""
        weight = self.weight + log_odds()
        return float(weight[weight > least].sum())


def weigh_alone(
    catalogue: Catalogue,
    log_area: FloatArray,
    matched: Matched,
    model_spread: float = MODEL_SPREAD,
    unsure: FloatArray | float = 0.0,
) -> Alone:
    """The arguments are those of `index_peaks`."""
    lines, peaks = weighed(
        catalogue.low_ev, catalogue.uncertainty, log_area, matched, model_spread, unsure
    )
    return Alone(
        lines, peaks, *evidence_scores(catalogue.first, lines, peaks, matched.log_peak)
    )  # fmt: skip


def weighed(
    low_ev: FloatArray,
    uncertainty: FloatArray,
    log_area: FloatArray,
    matched: Matched,
    model_spread: float,
    unsure: FloatArray | float = 0.0,
) -> tuple[Lines, Peaks]:
    """Lines and peaks as they are weighed; low_ev, uncertainty: of the catalogue's entries, (entries,)."""
    more = np.square(unsure) + np.zeros(len(log_area))
    spread = np.sqrt(more + (model_spread**2 + uncertainty * uncertainty))
    hidden = np.sqrt(more + MISSING_SPREAD**2)
    return (
        Lines(
            log_area,
            low_ev,
            spread,
            matched.peak,
            matched.away,
            matched.log_limit,
            matched.log_hidden,
            matched.stretch,
            matched.against,
            hidden,
        ),
        Peaks(matched.chance, matched.log_peak, matched.relative),
    )
