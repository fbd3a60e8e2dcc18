"""What the lines of a plot tell of cooler parts of the plasma: amounts for each part, and its odds.

Light of the hot zone passes through a cooler one, which absorbs and shines itself. All that one zone has
(`boltzmann`: temperature, density, opacity, amounts) is fitted again with a part of all atoms in the cool
one. Lines that begin at the ground shine there more than others, and lose more of the hot zone's light; with
several lines of an element, or several elements, the whole fit tells one from the other.
"""

from dataclasses import dataclass

import numpy as np

from ..spectrum.spectrum import FloatArray, IntArray
from .boltzmann import (
    CALIBRATION,
    USUAL_K,
    USUAL_LOG_NE,
    USUAL_NE_SPREAD,
    USUAL_SPREAD,
    Plot,
    PlotLines,
)
from .growth import log_depth_of_unit, log_kept
from .plot_fit import (
    COOLEST_K,
    GLOBAL,
    HOTTEST_K,
    LEAST_LN_NE,
    LONGEST_STEP,
    MOST_LN_NE,
    trust,
)

PARTS = np.geomspace(0.002, 0.6, 6)  # of the atoms that are cool; all as likely beforehand
COOL_KS, COOL_NE = (0.5, 0.7), 0.3  # temperatures and density there, beside the hot zone's
STEPS = 4  # each part begins where the one before ended
SLOPE = np.array([0.005, 0.02, 0.02])  # of ln T, ln n_e and ln of the opacity, for differences


@dataclass(frozen=True, slots=True, eq=False)
class CoolPart:
    """One of PARTS at one of COOL_KS: its odds, which add up to 1; ln of the amounts of the plot's elements,
    (k,), and their covariance (k, k), all else unknown."""

    odds: float
    log_scale: FloatArray
    covariance: FloatArray


def cool_parts(lines: PlotLines, plot: Plot) -> list[CoolPart]:
    """The plot fitted with each of PARTS at each of COOL_KS. lines: those of the plot."""
    which, k = np.searchsorted(plot.names, lines.element), len(plot.names)
    sigma = np.sqrt(lines.error**2 + CALIBRATION**2)
    p = np.array([np.log(plot.temperature_k), plot.log10_ne * np.log(10), plot.log_opacity])
    p = np.concatenate([p, plot.log_scale[plot.names]])
    toward, prior = p.copy(), np.full(len(p), 1e-9)
    toward[:2] = np.log(USUAL_K), USUAL_LOG_NE
    prior[:GLOBAL] = 1 / USUAL_SPREAD**2, 1 / USUAL_NE_SPREAD**2, 0.05
    misfits, found = [], []
    for cool_k in COOL_KS:
        at = p
        for part in PARTS:
            zones = _Zones(lines, which, k, float(part), cool_k)
            normal = np.diag(prior)
            for _ in range(STEPS):
                log_area, slopes = zones.with_slopes(at)
                z = (lines.log_area - log_area) / sigma
                weight = trust(z) / sigma**2
                normal = slopes.T @ (weight[:, None] * slopes) + np.diag(prior)
                gradient = slopes.T @ (weight * z * sigma) - prior * (at - toward)
                step = np.linalg.solve(normal, gradient)
                step[:GLOBAL] = np.clip(step[:GLOBAL], -LONGEST_STEP, LONGEST_STEP)
                at = at + step
                at[0] = np.clip(at[0], np.log(COOLEST_K), np.log(HOTTEST_K))
                at[1] = np.clip(at[1], LEAST_LN_NE, MOST_LN_NE)
            z = (lines.log_area - _log_area(*zones.at(at))) / sigma
            say = trust(z)
            # An outlier counts as in the fit: what it adds is bounded.
            misfits.append(np.sum(z**2 * np.sqrt(say)) + np.sum(prior * (at - toward) ** 2))
            chi2 = np.sum(say * z**2) / max(say.sum() - GLOBAL - k + 1, 1.0)
            covariance = np.linalg.inv(normal)[GLOBAL:, GLOBAL:] * max(chi2, 1.0)
            found.append((at[GLOBAL:], covariance))
    log_odds = -0.5 * np.array(misfits) / max(plot.chi2, 1.0)
    odds = np.exp(log_odds - log_odds.max())
    return [CoolPart(float(one), *of) for one, of in zip(odds / odds.sum(), found, strict=True)]


@dataclass(frozen=True, slots=True, eq=False)
class _Zones:
    """Lines, (n,), of k elements, `which` of them each is of, with a part of the atoms in a cool zone."""

    lines: PlotLines
    which: IntArray
    k: int
    part: float
    cool_k: float

    def with_slopes(self, p: FloatArray) -> tuple[FloatArray, FloatArray]:
        """ln of the lines' areas, (n,), and how they grow with each parameter, (n, 3 + k)."""
        hot, cool, hot_depth, cool_depth = self.at(p)
        log_area = _log_area(hot, cool, hot_depth, cool_depth)
        slopes = np.zeros((len(log_area), GLOBAL + self.k))
        for a in range(2):
            more = p.copy()
            more[a] += SLOPE[a]
            slopes[:, a] = (_log_area(*self.at(more)) - log_area) / SLOPE[a]
        thicker = _log_area(hot, cool, hot_depth + SLOPE[2], cool_depth + SLOPE[2])
        slopes[:, 2] = (thicker - log_area) / SLOPE[2]
        slopes[np.arange(len(log_area)), GLOBAL + self.which] = 1 + slopes[:, 2]
        return log_area, slopes

    def at(self, p: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """ln of the thin area of the hot and of the cool zone, and of the depths of both, each (n,)."""
        lines, kelvin, density = self.lines, float(np.exp(p[0])), float(np.exp(p[1]))
        scale, width = p[GLOBAL + self.which], lines.width_nm * density / 1e17
        cool_kelvin = self.cool_k * kelvin
        hot = lines.thin(kelvin, density) + scale + np.log1p(-self.part)
        cool = lines.thin(cool_kelvin, COOL_NE * density) + scale + np.log(self.part)
        hot_depth = p[2] + hot + log_depth_of_unit(lines.vacuum_nm, width, kelvin)
        cool_depth = p[2] + cool + log_depth_of_unit(lines.vacuum_nm, width, cool_kelvin)
        return hot, cool, hot_depth, cool_depth


def _log_area(hot, cool, hot_depth, cool_depth) -> FloatArray:
    """ln of the areas: of the light of both zones in a row what the cool one does not take, and its own.

    Of one zone a line's area is Planck's radiance times W(tau) = tau f(tau) (`growth`); both zones' lines
    are taken to be as wide. So the hot zone's light behind the cool is radiance (W(hot + cool) - W(cool)).
    """
    both = np.logaddexp(hot_depth, cool_depth)
    log_kept_cool = log_kept(cool_depth)[0]
    all_hot = hot - hot_depth + both + log_kept(both)[0]
    taken = hot - hot_depth + cool_depth + log_kept_cool
    passed = np.log1p(-np.minimum(np.exp(taken - all_hot), 1 - 1e-9))
    return np.logaddexp(all_hot + passed, cool + log_kept_cool)
