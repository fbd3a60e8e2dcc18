"""Say which elements a spectrum shows: weigh each, believe the surest, take its lines away, go on."""

from dataclasses import dataclass

import numpy as np

from .catalogue import Catalogue
from .commonness import log_odds
from .match import Matched
from .spectrum import FloatArray
from .weigh import accept, weigh_all

DETECTED, UNCERTAIN = 5.5, 3.0  # weights, prior included
MODEL_SPREAD = 0.35  # of ln(area): temperature, self-absorption, calibration


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


def index_peaks(
    catalogue: Catalogue,
    log_area: FloatArray,
    matched: Matched,
    model_spread: float = MODEL_SPREAD,
    least: float = UNCERTAIN,
    bonus: FloatArray | float = 0.0,
) -> Indexed:
    """Weigh all elements and accept, one after the other, those above `least`.

    log_area: ln of the area that each entry should have for one atom, shape (entries,). bonus:
    added to the weights, for evidence from elsewhere, shape (e,).
    """
    prior = log_odds() + bonus
    weight, scale, accepted, taken = accept(
        catalogue.first, log_area, catalogue.low_ev, _spread(catalogue, model_spread),
        matched.peak, matched.away, matched.log_limit, matched.chance, matched.log_peak,
        matched.relative, matched.area,
        prior, least,
    )  # fmt: skip
    total = float(weight[accepted].sum())
    return Indexed(weight, scale, accepted.tolist(), taken, total)


def likelihood(
    catalogue: Catalogue,
    log_area: FloatArray,
    matched: Matched,
    model_spread: float = MODEL_SPREAD,
    least: float = UNCERTAIN,
) -> float:
    """Sum of the weights above `least`, each by itself as if no other element claimed its peaks."""
    weight, _ = weigh_all(
        catalogue.first, log_area, catalogue.low_ev, _spread(catalogue, model_spread),
        matched.peak, matched.away, matched.log_limit, matched.chance, matched.log_peak,
        matched.log_peak, matched.relative,
    )  # fmt: skip
    weight += log_odds()
    return float(weight[weight > least].sum())


def _spread(catalogue: Catalogue, model_spread: float) -> FloatArray:
    return np.sqrt(model_spread**2 + catalogue.uncertainty**2)
