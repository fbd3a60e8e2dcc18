"""What the instrument's response is off by along the axis, from lines of the same elements.

The gains of two detectors may differ by a factor of ten, and a detector sees little near its ends.
Lines of one element on both sides tell: ln(area) = ln(strength) + ln(amount of the element) + b, b
joined by straight lines between knots, small and smooth unless the lines say otherwise. A line that
should show and does not bounds b from above.
"""

from dataclasses import dataclass

import numpy as np

from ..plasma.boltzmann import PlotLines
from ..plasma.plot_fit import trust
from ..plasma.response import LOOSE, Response, between, stiffness
from ..plasma.response import knots as places_of_knots
from ..spectrum.spectrum import FloatArray, IntArray

MODEL, RESONANT, RESONANT_EV = 0.3, 0.7, 1.5  # spread of ln(area); of lines that absorb themselves
HC_EV_NM = 1239.84198
TURNS = 8
LEAST_LINES = 6
CLEARLY = 8.0  # gain in chi2 that a response must bring, its prior counted


@dataclass(frozen=True, slots=True, eq=False)
class Missing:
    """Lines that should show and do not, shape (m,): element, vacuum nm, ln of the area for one
    atom less ln of the area from which it would be seen."""

    element: IntArray
    vacuum_nm: FloatArray
    log_above: FloatArray


def find_response(
    lines: PlotLines,
    missing: Missing,
    states: tuple[tuple[float, float], ...],
    range_nm: tuple[float, float],
    seams_nm: FloatArray,
) -> tuple[Response, tuple[float, float]] | None:
    """The response and the state that explain the lines best; None if a level one does as well.

    states: temperatures (K) and densities (per cm3) to try. seams_nm: places, in ascending order,
    where one detector may end and another begin.
    """
    if len(lines) < LEAST_LINES:
        return None
    knots = places_of_knots(range_nm, seams_nm)
    best, level = None, np.inf
    for state in states:
        flat, _, _ = _fit(lines, missing, state, knots, seams_nm, free=False)
        level = min(level, flat)
        found = _fit(lines, missing, state, knots, seams_nm, free=True)
        if best is None or found[0] < best[0][0]:
            best = found, state
    assert best is not None
    (chi2, gain, error), state = best
    if level - chi2 < CLEARLY:
        return None
    return Response(knots, np.asarray(gain, np.float64), error), state


def _fit(lines: PlotLines, missing: Missing, state, knots, seams_nm, *, free: bool):
    """Robust cost, b at the knots and its error."""
    names, which = np.unique(np.concatenate([lines.element, missing.element]), return_inverse=True)
    n, k = len(lines), len(knots)
    at = np.concatenate([lines.vacuum_nm, missing.vacuum_nm])
    seen = np.arange(len(at)) < n
    y = np.concatenate([lines.log_area - lines.thin(*state), -missing.log_above])
    low_ev = lines.e_k_ev - HC_EV_NM / lines.vacuum_nm
    spread = np.where(low_ev < RESONANT_EV, RESONANT, MODEL)
    sigma = np.concatenate([np.hypot(spread, lines.error), np.full(len(at) - n, 2 * MODEL)])
    design = np.zeros((len(at), k + len(names)))
    if free:
        place, part = between(knots, at)
        rows = np.arange(len(at))
        design[rows, place], design[rows, place + 1] = 1.0 - part, part
    design[np.arange(len(at)), k + which] = 1.0
    prior = 1e-8 * np.eye(k + len(names))
    prior[:k, :k] = stiffness(knots, seams_nm, LOOSE)
    p = np.zeros(k + len(names))
    for e in range(len(names)):
        own = seen & (which == e)
        p[k + e] = np.median(y[own]) if own.any() else 0.0
    normal = prior
    for turn in range(TURNS):
        z = (y - design @ p) / sigma
        z = np.where(seen, z, np.minimum(z, 0.0))  # a line that is missing has only a limit
        weight = (trust(0.5 * z if turn < 3 else z)) / sigma**2
        weight = np.where(seen | (z < 0.0), weight, 0.0)
        normal = design.T @ (weight[:, None] * design) + prior
        p = np.linalg.solve(normal, design.T @ (weight * y))
    z = (y - design @ p) / sigma
    z = np.where(seen, z, np.minimum(z, 0.0))
    cost = float(np.sum(OUTLIER_COST * z**2 / (OUTLIER_COST + z**2)) + p @ prior @ p)
    # The level itself is in the amounts: only differences along the axis have an error here.
    middle = np.eye(k) - np.full((k, k), 1.0 / k)
    error = np.sqrt(np.diag(middle @ np.linalg.inv(normal)[:k, :k] @ middle))
    return cost, p[:k], error


OUTLIER_COST = 6.25  # what an outlier costs in chi2 at most, as of `trust`
