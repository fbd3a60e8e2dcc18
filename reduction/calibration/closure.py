"""Concentrations without standards: the amounts of the Saha-Boltzmann plot, closed to 100 %.

Calibration-free LIBS (Ciucci et al., Appl. Spectrosc. 53, 960 (1999)): the plasma is taken to have
the sample's composition, and all that the sample holds to have lines in the plot, oxygen excepted,
which a rock's cations bind in a known ratio. An element that is not seen gets an upper limit.

One standard of the same instrument makes up for what all spectra lack alike, response and transition
probabilities (one-point calibration: Cavalcanti et al., Spectrochim. Acta B 87, 51 (2013)); there a
factor for each line, here one for each element's amount.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..elements.evidence_score import NOT_SEEN
from ..elements.identify import Identified
from ..lines.formula import WEIGHT, Closed, with_oxygen
from ..plasma.lithium_share import THICK, UNIFORM, cations
from ..plasma.strengths import atoms
from ..reduce import Reduction
from ..spectrum.spectrum import BoolArray, FloatArray, TextArray
from .calibration import Concentration, OnePoint

NORMAL_95 = 1.96
MOST_ERROR = 1.5  # of ln(amount): with more an element's amount is not told
# What a response that had to be found in the same lines leaves of each ln(amount): on 14 measured
# minerals the median amount was off by a factor of 1.9.
UNKNOWN_RESPONSE = 0.6
LEAST_SHOTS = 3  # whose scatter is an error


@dataclass(frozen=True, slots=True, eq=False)
class _Amounts:
    """ln(mass) of the plot's elements, arbitrary unit, shape (n,), with the covariance of the plot's fit.
    counted: whose mass is known and which are no gas. lost: e-folds of light lost."""

    names: TextArray
    counted: BoolArray
    log_mass: FloatArray
    covariance: FloatArray
    lost: FloatArray


def _amounts(found: Identified | None) -> _Amounts | None:
    if found is None or found.plot is None or found.lines is None:
        return None
    plot = found.plot
    names = atoms().elements[plot.names]
    counted = cations(plot.names) & np.array([name in WEIGHT for name in names])
    if not counted.any():
        return None
    log_mass = plot.log_scale[plot.names] + np.log([WEIGHT.get(name, 1.0) for name in names])
    return _Amounts(names, counted, log_mass, plot.covariance, _lost(found, len(names)))


def one_point(
    standards: Sequence[tuple[Mapping[str, float], Sequence[Reduction]]],
) -> dict[str, OnePoint]:
    """What the shots of one standard or more tell of each element: (wt % by element, reductions) of each.

    ln(known / found), up to what all elements of a shot share, which a closure does not need.
    """
    told: dict[str, list[tuple[float, float, float]]] = {}
    for wt_percent, shots in standards:
        for shot in shots:
            found = _amounts(shot.identified)
            if found is None:
                continue
            own = found.counted & np.array([wt_percent.get(name, 0.0) > 0 for name in found.names])
            if own.sum() < 2:
                continue
            known = np.log([wt_percent[name] for name in found.names[own]])
            factor = known - found.log_mass[own]
            # As a mean over the mass, so that the element of which there is most is the steadiest.
            factor = factor - np.average(factor, weights=np.exp(known))
            fitted = np.sqrt(np.diag(found.covariance)[own])
            for name, *each in zip(found.names[own], factor, fitted, found.lost[own], strict=True):
                told.setdefault(str(name), []).append((each[0], each[1], each[2]))
    points = {}
    for name, rows in told.items():
        factor, fitted, lost = np.array(rows).T
        enough = len(rows) >= LEAST_SHOTS
        error = float(factor.std(ddof=1)) if enough else float(np.median(fitted))
        points[name] = OnePoint(float(np.median(factor)), error, float(np.median(lost)))
    return points


def concentrations(
    reduction: Reduction, closed: Closed, points: Mapping[str, OnePoint] | None = None
) -> dict[str, Concentration]:
    """wt % by element, with standard errors and 95 % intervals; empty where no plot tells amounts.

    ln(amount) has the covariance of the plot, and for each element what one zone in equilibrium
    lacks. Intervals are of the logit of the mass fraction, so that they end within 0 and 100 %.
    points: of a one-point calibration, by element.
    """
    found, told = reduction.identified, _amounts(reduction.identified)
    if found is None or told is None:
        return {}
    names, counted, log_mass = told.names, told.counted, told.log_mass
    bound = np.array([with_oxygen(name, closed) for name in names])
    own = np.hypot(UNIFORM, THICK * told.lost)
    if found.response is not None:
        own = np.hypot(own, UNKNOWN_RESPONSE)
    for k, name in enumerate(names.tolist()):
        if points and name in points:
            point = points[name]
            log_mass[k] += point.log_factor
            unlike = THICK * (told.lost[k] - point.lost)
            own[k] = float(np.sqrt(UNIFORM**2 + unlike**2 + point.error**2))
        elif points:
            own[k] = np.hypot(own[k], np.std([one.log_factor for one in points.values()]))
    covariance = told.covariance + np.diag(own**2)
    while True:
        log_whole = np.where(counted, log_mass + np.log(bound), -np.inf)
        top = float(log_whole.max())
        whole = float(np.exp(log_whole - top).sum())
        parts = np.exp(log_whole - top) / whole
        turn = np.eye(len(names)) - parts
        error = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", turn, covariance, turn), 0.0))
        if not counted.any() or not np.any(error[counted] > MOST_ERROR):
            break
        # The one that the lines tell least would make all the others as unsure.
        counted[np.argmax(np.where(counted, np.diag(covariance), -1.0))] = False
    if not counted.any():
        return {}
    flags = _missing(reduction, names[counted])
    uncalibrated = ("no standard told it",) if points else ()
    said = {}
    for k in np.flatnonzero(counted):
        part = float(parts[k] / bound[k])
        doubt = () if names[k] in reduction.detected else ("uncertain",)
        doubt += () if names[k] in (points or {}) else uncalibrated
        low, high = _interval(part, float(error[k]))
        said[str(names[k])] = Concentration(
            100 * part, 100 * part * float(error[k]), low, high, (*doubt, *flags)
        )
    return said | _limits(found, said, top + float(np.log(whole)), float(own.mean()))


def _interval(part: float, error: float) -> tuple[float, float]:
    """Ends of the 95 % interval, wt %; error of ln(part)."""
    part = min(max(part, 1e-12), 1 - 1e-9)
    logit, spread = np.log(part / (1 - part)), NORMAL_95 * error / (1 - part)
    low, high = (100 / (1 + np.exp(-logit - s * min(spread, 50.0))) for s in (-1, 1))
    return float(low), float(high)


def _lost(found: Identified, n: int) -> FloatArray:
    """e-folds of light that each element's lines lost to self-absorption, in the mean; (n,)."""
    plot, lines = found.plot, found.lines
    assert plot is not None and lines is not None
    which = np.searchsorted(plot.names, lines.element)
    log_kept = -np.log(np.maximum(plot.kept, 1e-12))
    return np.bincount(which, log_kept, n) / np.maximum(np.bincount(which, minlength=n), 1)


def _missing(reduction: Reduction, names) -> tuple[str, ...]:
    """A sentence on detected elements that the plot has no line of: the closure lacks them."""
    gone = [
        name
        for name in reduction.detected
        if name in WEIGHT
        and name not in names
        and cations(np.searchsorted(atoms().elements, [name]))[0]
    ]
    return (f"closed without {' '.join(sorted(gone))}",) if gone else ()


def _limits(
    found: Identified, said: dict[str, Concentration], log_whole: float, error: float
) -> dict[str, Concentration]:
    """Of elements that were not accepted: what their clearest missing line could hide, wt %."""
    limits = {}
    first = found.catalogue.first
    for e, name in enumerate(atoms().elements.tolist()):
        own = np.arange(first[e], first[e + 1])
        own = own[found.matched.peak[own] == NOT_SEEN]
        unseen = name not in said and name in WEIGHT and e not in found.indexed.accepted
        if not (unseen and len(own) and cations(np.array([e]))[0]):
            continue
        log_amount = float(np.min(found.matched.log_limit[own] - found.effective[own]))
        log_part = log_amount + np.log(WEIGHT[name]) - log_whole + NORMAL_95 * error
        high = 100 * np.exp(min(log_part, 1.0))
        if high < 100:
            limits[name] = Concentration(None, None, None, float(high), ("below LOD",))
    return limits
