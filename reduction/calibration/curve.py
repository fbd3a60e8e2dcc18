"""A calibration curve: fitted with the scatter of shots and of standards, and read backwards.

The signal of a standard of concentration c is f(c) = b0 + b1 u + b2 u^2, u = c / the highest. It
scatters from shot to shot (a floor, and a part of itself) and, beyond that, from standard to
standard (matrix, self-absorption, drift: again a floor and a part of itself). The latter two are
means over their restricted likelihood, so that few standards do not claim to scatter by nothing.
"""

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from ..spectrum.spectrum import FloatArray

ONE_SIGMA, TWO_SIDED_95 = 0.8413447, 0.975
PARTS = np.concatenate([[0.0], np.geomspace(3e-3, 1.0, 12)])  # of the signal
FLOORS = np.concatenate([[0.0], np.geomspace(1e-5, 0.3, 14)])  # of the highest signal
BEYOND = 3.0  # highest concentrations, up to which a curve is read
GRID = np.linspace(0.0, 1.0, 1_200) ** 3
TURNS = 3


class Estimate(NamedTuple):
    """wt_percent with its standard error (half of the 68 % interval), and the 95 % interval.

    high is infinite where the curve has no upper end for the signal.
    """

    wt_percent: float
    error: float
    low: float
    high: float


@dataclass(frozen=True, slots=True)
class Curve:
    """highest: concentration of the highest standard, wt %. coefficients: of u, lowest power first,
    with their covariance. floor, part: scatter of a shot; standards_floor, standards_part: of
    standards beyond that; floors in the signal's unit, parts of the signal."""

    highest: float
    coefficients: tuple[float, ...]
    covariance: tuple[tuple[float, ...], ...]
    floor: float
    part: float
    standards_floor: float
    standards_part: float
    freedom: int

    def signal(self, wt_percent: FloatArray) -> FloatArray:
        """The signal expected of concentrations, any shape."""
        u = np.asarray(wt_percent) / self.highest
        return np.sum([b * u**k for k, b in enumerate(self.coefficients)], axis=0)

    def slope(self, wt_percent: float) -> float:
        """Signal per wt %."""
        u = wt_percent / self.highest
        risen = sum(k * b * u ** (k - 1) for k, b in enumerate(self.coefficients) if k)
        return float(risen) / self.highest

    def sigma(self, wt_percent: FloatArray, shots: int = 1, noise: float = 0.0) -> FloatArray:
        """Standard deviation of a new sample's mean signal around the curve, the curve's error
        included. noise: of one of its shots, where that is greater than the standards'."""
        f = self.signal(wt_percent)
        shot = (max(self.floor, noise) ** 2 + (self.part * f) ** 2) / shots
        sample = self.standards_floor**2 + (self.standards_part * f) ** 2
        powers = np.vander(
            np.atleast_1d(wt_percent) / self.highest, len(self.coefficients), increasing=True
        )
        own = ((powers @ np.array(self.covariance)) * powers).sum(axis=1)
        return np.sqrt(shot + sample + own.reshape(np.shape(f)))

    def leverage(self, wt_percent: FloatArray, shots: FloatArray) -> FloatArray:
        """The part that each standard has in the curve at its own place, 0 to 1, shape (n,): the diagonal of
        the weighted hat matrix, the number of coefficients in sum."""
        f = self.signal(wt_percent)
        variance = (self.floor**2 + (self.part * f) ** 2) / shots
        variance = variance + self.standards_floor**2 + (self.standards_part * f) ** 2
        powers = np.vander(wt_percent / self.highest, len(self.coefficients), increasing=True)
        return ((powers @ np.array(self.covariance)) * powers).sum(axis=1) / variance

    def blank_sigma(self, shots: int = 1, noise: float = 0.0) -> float:
        """The same for a sample without the element."""
        return float(self.sigma(np.array(0.0), shots, noise))

    def lod(self, shots: int = 1, noise: float = 0.0) -> float:
        """Limit of detection, wt %: 3 standard deviations of a blank over the slope at 0 (IUPAC)."""
        return 3.0 * self.blank_sigma(shots, noise) / self.slope(0.0)

    def loq(self, shots: int = 1, noise: float = 0.0) -> float:
        """Limit of quantification, wt %: 10 standard deviations of a blank over the slope."""
        return 10.0 * self.blank_sigma(shots, noise) / self.slope(0.0)

    @property
    def top(self) -> float:
        """The concentration up to which the curve rises and is read, wt %."""
        b = list(self.coefficients)
        bent = len(b) > 2 and b[2] < 0
        return self.highest * (min(-b[1] / (2 * b[2]), BEYOND) if bent else BEYOND)

    def inverse(self, signal: float) -> float:
        """The concentration at which the curve has this signal, wt %; `top` for all that is above,
        below 0 for what is less than a blank's."""
        if signal < self.coefficients[0]:
            return (signal - self.coefficients[0]) / self.slope(0.0)
        c = self.top * GRID
        return float(np.interp(signal, self.signal(c), c))

    def read(self, signal: float, shots: int = 1, noise: float = 0.0) -> Estimate:
        """The concentration of a mean signal: the curve backwards, and all concentrations that
        would show such a signal (inverse regression with Student's t)."""
        c, value = self.top * GRID, self.inverse(signal)
        f, sigma = self.signal(c), self.sigma(c, shots, noise)
        inside = np.flatnonzero(np.abs(signal - f) <= quantile(TWO_SIDED_95, self.freedom) * sigma)
        near = float(np.interp(max(value, 0.0), c, sigma))
        slope = max(self.slope(max(value, 0.0)), 0.02 * self.slope(0.0))
        error = quantile(ONE_SIGMA, self.freedom) * near / slope
        if not len(inside):
            near_end = float(c[-1]) if signal > f[0] else 0.0
            return Estimate(value, error, near_end, np.inf if near_end else 0.0)
        last = inside[-1] == len(c) - 1
        return Estimate(value, error, float(c[inside[0]]), np.inf if last else float(c[inside[-1]]))


@lru_cache(maxsize=64)
def quantile(part: float, freedom: int) -> float:
    """Of Student's t."""
    return float(stdtrit(freedom, part))


def fit_curve(
    wt_percent: FloatArray, signal: FloatArray, shots: FloatArray, floor: float, part: float,
    degree: int,
) -> Curve:  # fmt: skip
    """The curve through standards' mean signals, all of shape (n,); floor, part: scatter of a shot."""
    highest = float(wt_percent.max())
    powers = np.vander(wt_percent / highest, degree + 1, increasing=True)
    f = np.maximum(signal, 0.0)
    top = float(np.max(np.abs(signal)))
    floors, parts = (one.ravel() for one in np.meshgrid(FLOORS * top, PARTS))
    beta, covariance = np.zeros(degree + 1), np.zeros((degree + 1, degree + 1))
    excess = share = 0.0
    for _ in range(TURNS):
        own = (floor**2 + (part * f) ** 2) / shots
        variance = own + floors[:, None] ** 2 + (parts[:, None] * f) ** 2
        normal = np.einsum("gn,np,nq->gpq", 1 / variance, powers, powers)
        right = np.einsum("gn,np,n->gp", 1 / variance, powers, signal)
        betas = np.linalg.solve(normal, right[..., None])[..., 0]
        left = signal - betas @ powers.T
        likelihood = -0.5 * (
            np.log(variance).sum(axis=1) + np.linalg.slogdet(normal)[1]
            + (left**2 / variance).sum(axis=1)
        )  # fmt: skip
        weight = np.exp(likelihood - likelihood.max())
        weight /= weight.sum()
        excess, share = float(weight @ floors**2), float(weight @ parts**2)
        inverse = 1 / (own + excess + share * f**2)
        covariance = np.linalg.inv((powers.T * inverse) @ powers)
        beta = covariance @ (powers.T @ (inverse * signal))
        f = np.maximum(powers @ beta, 0.0)
    return Curve(
        highest, tuple(beta.tolist()), tuple(map(tuple, covariance.tolist())), float(floor),
        float(part), excess**0.5, share**0.5, max(len(signal) - degree - 1, 1),
    )  # fmt: skip


def cross_validated(
    curve: Curve, wt_percent: FloatArray, signal: FloatArray, shots: FloatArray
) -> FloatArray:
    """Each standard's concentration by the curve through the others, wt %, shape (n,).

    How standards scatter is taken from all of them.
    """
    powers = np.vander(wt_percent / curve.highest, len(curve.coefficients), increasing=True)
    f = curve.signal(wt_percent)
    variance = (curve.floor**2 + (curve.part * f) ** 2) / shots
    variance = variance + curve.standards_floor**2 + (curve.standards_part * f) ** 2
    weighted = powers / np.sqrt(variance)[:, None], signal / np.sqrt(variance)
    found = np.zeros(len(signal))
    for k in range(len(signal)):
        rest = np.arange(len(signal)) != k
        beta = np.linalg.lstsq(weighted[0][rest], weighted[1][rest], rcond=None)[0]
        other = replace(curve, coefficients=tuple(beta.tolist()))
        if other.slope(0.0) > 0:
            found[k] = max(other.inverse(float(signal[k])), 0.0)
    return found
