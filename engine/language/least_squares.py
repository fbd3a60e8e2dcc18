"""A polynomial through points, by least squares: numpy's job, in the thirty lines that are needed of it."""

import math
from collections.abc import Sequence
from operator import mul


def least_squares(xs: Sequence[float], ys: Sequence[float], degree: int) -> list[float]:
    """The coefficients, the highest power first; `xs` has more than `degree` different values.

    Polynomials that are orthogonal over the points are made one from the other, so that no system of
    equations has to be solved (Forsythe, J. SIAM 5, 74, 1957); x is shifted and scaled to -1 to 1
    meanwhile.
    """
    middle = (max(xs) + min(xs)) / 2
    scale = (max(xs) - min(xs)) / 2 or 1.0
    places = [(x - middle) / scale for x in xs]
    before, now = [0.0] * len(places), [1.0] * len(places)  # the last two, at the points
    before_terms, terms = [0.0], [1.0]  # and their coefficients, the lowest power first
    squared_before, rest, found = 1.0, list(ys), [0.0] * (degree + 1)
    for k in range(degree + 1):
        squared = math.fsum(map(mul, now, now))
        # Of what the lower ones left, not of y: the same in theory, and better in 53 bits.
        share = math.fsum(map(mul, rest, now)) / squared
        rest = [left - share * value for left, value in zip(rest, now, strict=True)]
        found = _plus(found, terms, share)
        shift = math.fsum(map(mul, places, map(mul, now, now))) / squared
        weight = squared / squared_before if k else 0.0
        following = [
            (t - shift) * value - weight * old
            for t, value, old in zip(places, now, before, strict=True)
        ]
        next_terms = _plus(_plus([0.0, *terms], terms, -shift), before_terms, -weight)
        before, now, squared_before = now, following, squared
        before_terms, terms = terms, next_terms
    return _in_x(found, middle, scale)[::-1]


def _plus(terms: list[float], others: list[float], factor: float) -> list[float]:
    longer = max(len(terms), len(others))
    a, b = (some + [0.0] * (longer - len(some)) for some in (terms, others))
    return [one + factor * other for one, other in zip(a, b, strict=True)]


def _in_x(terms: list[float], middle: float, scale: float) -> list[float]:
    """The coefficients of powers of x from those of (x - middle) / scale."""
    scaled = [term / scale**k for k, term in enumerate(terms)]
    return [
        math.fsum(math.comb(n, k) * scaled[n] * (-middle) ** (n - k) for n in range(k, len(scaled)))
        for k in range(len(scaled))
    ]
