"""What the instrument's response is off by along the axis, from lines of the same elements.

The gains of two detectors may differ by a factor of ten, and a detector sees little near its ends.
Lines of one element on both sides tell: ln(area) = ln(strength) + ln(amount of the element) + b, b
joined by straight lines between knots, small and smooth unless the lines say otherwise. A line that
should show and does not bounds b from above.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..peaks.levenberg import factorise, solve
from ..plasma.boltzmann import Bend, PlotLines
from ..plasma.plot_fit import inverse, trust
from ..plasma.response import Response, between
from ..plasma.strengths import present
from ..spectrum.curve import median
from ..spectrum.kernel import inner_kernel, kernel
from ..spectrum.spectrum import FloatArray, IntArray

MODEL, RESONANT, RESONANT_EV = 0.3, 0.7, 1.5  # spread of ln(area); of lines that absorb themselves
HC_EV_NM = 1239.84198
TURNS = 8
LEAST_LINES = 6
OUTLIER_COST = 6.25  # what an outlier costs in chi2 at most, as of `trust`
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
    bend: Bend,
) -> tuple[Response, tuple[float, float]] | None:
    """The response and the state that explain the lines best; None if a level one does as well.

    states: temperatures (K) and densities (per cm3) to try. bend: the response beforehand.
    """
    if len(lines) < LEAST_LINES:
        return None
    knots, stiff = bend.knots_nm, bend.stiff
    names, which = present(np.concatenate([lines.element, missing.element]))
    at = np.concatenate([lines.vacuum_nm, missing.vacuum_nm])
    n_seen = len(lines)
    low_ev = lines.e_k_ev - HC_EV_NM / lines.vacuum_nm
    spread = np.where(low_ev < RESONANT_EV, RESONANT, MODEL)
    hidden = np.full(len(at) - n_seen, 2 * MODEL)
    sigma = np.concatenate([np.hypot(spread, lines.error), hidden])
    place, part = between(knots, at)
    best, level = None, np.inf
    kelvin, density = np.array(states).T
    for state, thin in zip(states, lines.thin(kelvin, density), strict=True):
        y = np.concatenate([lines.log_area - thin, -missing.log_above])
        seen = _Seen(y, sigma, which, place, part)
        level = min(level, _fit(seen, n_seen, len(names), stiff, False)[0])
        found = _fit(seen, n_seen, len(names), stiff, True)
        if best is None or found[0] < best[0][0]:
            best = found, state
    assert best is not None
    (chi2, gain, covariance), state = best
    if level - chi2 < CLEARLY:
        return None
    # The level itself is in the amounts: only differences along the axis have an error here.
    k = len(knots)
    middle = np.eye(k) - np.full((k, k), 1.0 / k)
    return Response(knots, gain, np.sqrt(np.diag(middle @ covariance @ middle))), state


class _Seen(NamedTuple):
    """Of the lines, those that are missing last, shape (n,): ln(area) for one atom, its error, which
    element, the knot before it and which part of the way to the next it is."""

    y: FloatArray
    sigma: FloatArray
    which: IntArray
    place: IntArray
    part: FloatArray


@kernel
def _fit(lines, n_seen, n_names, stiff, free):
    """Robust cost, b at the knots and its covariance; with b = 0 throughout where it is not free."""
    y, sigma, which, place, part = lines
    k = len(stiff) if free else 0
    n, n_p = len(y), k + n_names
    p, gradient, step = np.zeros(n_p), np.empty(n_p), np.zeros(n_p)
    normal, lower = np.empty((n_p, n_p)), np.zeros((n_p, n_p))
    own = np.empty(n_seen)
    for e in range(n_names):
        n_own = 0
        for i in range(n_seen):
            if which[i] == e:
                own[n_own] = y[i]
                n_own += 1
        p[k + e] = median(own[:n_own]) if n_own else 0.0
    for turn in range(TURNS):
        gradient.fill(0.0)
        normal.fill(0.0)
        for a in range(k):
            for b in range(k):
                normal[a, b] = stiff[a, b]
        for e in range(k, n_p):
            normal[e, e] = 1e-8
        for i in range(n):
            z = _left(lines, p, k, i, n_seen) / sigma[i]
            if i >= n_seen and z >= 0.0:
                continue  # a line that is missing has only a limit
            w = trust(0.5 * z if turn < 3 else z) / sigma[i] ** 2
            e = k + which[i]
            normal[e, e] += w
            gradient[e] += w * y[i]
            if k == 0:
                continue
            b, far = place[i], part[i]
            near = 1.0 - far
            normal[b, b] += w * near * near
            normal[b + 1, b] += w * near * far
            normal[b + 1, b + 1] += w * far * far
            normal[e, b] += w * near
            normal[e, b + 1] += w * far
            gradient[b] += w * near * y[i]
            gradient[b + 1] += w * far * y[i]
        factorise(normal, lower)
        solve(lower, gradient, step)
        for a in range(n_p):  # p[:] = step compiles the words of an error, 2 s
            p[a] = step[a]
    cost = 0.0
    for a in range(k):
        for b in range(k):
            cost += p[a] * stiff[a, b] * p[b]
    for i in range(n):
        z = _left(lines, p, k, i, n_seen) / sigma[i]
        cost += OUTLIER_COST * z * z / (OUTLIER_COST + z * z)
    covariance = inverse(normal, lower)[:k, :k].copy() if free else np.empty((0, 0))
    return cost, p[:k].copy(), covariance


@inner_kernel
def _left(lines, p, k, i, n_seen):
    """What is left over of one line; of one that is missing, only what it should be fainter by."""
    y, _, which, place, part = lines
    left = y[i] - p[k + which[i]]
    if k > 0:
        left -= (1.0 - part[i]) * p[place[i]] + part[i] * p[place[i] + 1]
    return left if i < n_seen else min(left, 0.0)
