"""What the instrument's response is off by along the axis: ln of it at knots, joined by lines."""

from dataclasses import dataclass

import numpy as np

from ..spectrum.kernel import kernel
from ..spectrum.spectrum import FloatArray

KNOT_NM = 40.0


@dataclass(frozen=True, slots=True, eq=False)
class Response:
    """ln of the response at knots on the axis (vacuum nm), and its standard error; shape (k,)."""

    knots_nm: FloatArray
    log_gain: FloatArray
    error: FloatArray

    def at(self, vacuum_nm: FloatArray) -> FloatArray:
        """ln of the response, any shape; level beyond the outer knots."""
        return np.interp(vacuum_nm, self.knots_nm, self.log_gain)

    def error_at(self, vacuum_nm: FloatArray) -> FloatArray:
        return np.interp(vacuum_nm, self.knots_nm, self.error)


@dataclass(frozen=True, slots=True)
class Usual:
    """What a response is expected to be, as standard deviations of its ln: its change to a knot
    KNOT_NM away, over a seam, and its distance from level."""

    per_knot: float
    per_seam: float
    overall: float


LOOSE = Usual(0.45, 1.3, 3.0)  # of any instrument
OPEN = Usual(1.0, 1.5, 4.0)  # the same where T is told: detectors fall off faster at their ends
DOUBTFUL = Usual(0.25, 0.6, 1.0)  # of one that nothing shows, while the lines scatter too much
STEPPED = Usual(0.04, 1.3, 3.0)  # of one that is level but for jumps, which its light shows
LEVEL = Usual(0.04, 0.1, 0.1)  # of one whose response was divided out


def knots(range_nm: tuple[float, float], seams_nm: FloatArray) -> FloatArray:
    """Places of the knots: even, and on both sides of a seam."""
    first, last = range_nm
    even = np.linspace(first, last, max(round((last - first) / KNOT_NM), 1) + 1)
    inside = seams_nm[(seams_nm > first + 1) & (seams_nm < last - 1)]
    even = even[np.abs(even[:, None] - inside).min(axis=1, initial=np.inf) > 0.3 * KNOT_NM]
    return np.unique(np.concatenate([even, inside - 0.5, inside + 0.5]))


def stiffness(knots_nm: FloatArray, seams_nm: FloatArray, usual: Usual) -> FloatArray:
    """What is known beforehand, as the inverse of a covariance, (k, k)."""
    ascending = np.sort(seams_nm)
    after = np.searchsorted(ascending, knots_nm[:-1], "right")
    seam = np.searchsorted(ascending, knots_nm[1:]) > after
    step = np.sqrt(np.diff(knots_nm) / KNOT_NM)
    w = 1.0 / np.where(seam, usual.per_seam, usual.per_knot * step) ** 2
    own = np.full(len(knots_nm), 1.0 / usual.overall**2)
    own[:-1] += w
    own[1:] += w
    return np.diag(own) - np.diag(w, 1) - np.diag(w, -1)


@kernel
def between(knots_nm, at_nm):
    """The knot before each place, (n,), and which part of the way to the next it is; level outside."""
    place, part = np.zeros(len(at_nm), np.int64), np.zeros(len(at_nm))
    last = len(knots_nm) - 2
    for i in range(len(at_nm)):
        b = min(max(np.searchsorted(knots_nm, at_nm[i]) - 1, 0), last)
        far = (at_nm[i] - knots_nm[b]) / (knots_nm[b + 1] - knots_nm[b])
        place[i], part[i] = b, min(max(far, 0.0), 1.0)
    return place, part
