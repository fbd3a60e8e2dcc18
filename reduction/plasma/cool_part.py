"""What the lines of a plot tell of cooler parts of the plasma: amounts for each part, and its odds.

Light of the hot zone passes through a cooler one, which absorbs and shines itself. All that one zone has
(`boltzmann`: temperature, density, opacity, amounts) is fitted again with a part of all atoms in the cool
one. Lines that begin at the ground shine there more than others, and lose more of the hot zone's light; with
several lines of an element, or several elements, the whole fit tells one from the other. How hot and dense
that zone is, and what the response may be off by, is fitted, too: what one zone took for a bent response may
have been a cool part.
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
    Bend,
    Plot,
    PlotLines,
)
from .growth import growing, log_depth_of_unit, log_kept
from .plot_fit import (
    COOLEST_K,
    GLOBAL,
    HOTTEST_K,
    LEAST_LN_NE,
    LONGEST_STEP,
    MOST_LN_NE,
    trust,
)
from .response import between

# Of the atoms, those that are cool: even in the angle whose squared sine they are, all as likely beforehand
# (Jeffreys' prior of a share).
PARTS = np.sin(np.linspace(0.05, 0.95, 8)) ** 2
# Temperature and density there beside the hot zone's, and how far they may be from it (of the ln).
COOL_K, COOL_K_SPREAD = 0.6, 0.2
COOL_NE, COOL_NE_SPREAD = 0.3, 0.7
COOL_ENDS = np.log([[0.4, 0.85], [0.03, 1.0]])
ZONES = GLOBAL + 2  # parameters that all lines share: these two after the plot's
LONGEST_STEPS = np.concatenate([LONGEST_STEP, [0.15, 0.5]])
FEW = 10.0  # lines, by which the scatter of the others is taken to be as their errors say
STEPS = 6, 3
SLOPE = np.array([0.005, 0.02, 0.02, 0.01, 0.05])  # of the first parameters, for differences
# Places across half a line: angles whose tangents are in half widths of the hot zone's line; their weights.
_AT, _WEIGHT = np.polynomial.legendre.leggauss(12)
_SQUARE = np.tan((_AT + 1) * np.pi / 4) ** 2
_WEIGHT = 0.5 * _WEIGHT * (1 + _SQUARE)


@dataclass(frozen=True, slots=True, eq=False)
class CoolPart:
    """One of the parts: its odds, which add up to 1; ln of the amounts of the plot's elements, (k,), and
    their covariance (k, k), all else unknown. evidence: ln of how likely the lines are with this part and
    this knowledge of the response, whatever all parameters are (Laplace's approximation), but for a
    constant. scatter: mean square of what lines are off by, in their own errors."""

    odds: float
    log_scale: FloatArray
    covariance: FloatArray
    evidence: float
    scatter: float


def cool_parts(
    lines: PlotLines, plot: Plot, bend: Bend, parts: FloatArray = PARTS, steps: tuple[int, int] = STEPS
) -> list[CoolPart]:  # fmt: skip
    """The plot fitted with each of some parts. lines: those of the plot, without its response; bend: the
    response beforehand, as it was for the plot. steps: of the first part, and of each other, which begins
    where the one before ended."""
    which, k = np.searchsorted(plot.names, lines.element), len(plot.names)
    knot, far = np.zeros(len(lines), np.int64), np.zeros(len(lines))
    if len(bend.knots_nm):
        knot, far = between(bend.knots_nm, lines.vacuum_nm)
    zones = _Zones(lines, which, k, knot, far)
    shown = lines.log_area
    p = np.array([np.log(plot.temperature_k), plot.log10_ne * np.log(10), plot.log_opacity])
    p = np.concatenate([p, np.log([COOL_K, COOL_NE]), plot.log_scale[plot.names]])
    if len(bend.knots_nm):
        p = np.concatenate([p, bend.start if plot.response is None else plot.response.log_gain])
    if plot.response is not None:
        shown = shown + plot.response.at(lines.vacuum_nm)
    sigma = _errors(lines, plot)
    toward = np.zeros(len(p))
    toward[:2], toward[2 : ZONES + k] = (np.log(USUAL_K), USUAL_LOG_NE), p[2 : ZONES + k]
    prior = 1e-9 * np.eye(len(p))
    prior[range(ZONES), range(ZONES)] = (
        1 / USUAL_SPREAD**2, 1 / USUAL_NE_SPREAD**2, 0.05, 1 / COOL_K_SPREAD**2, 1 / COOL_NE_SPREAD**2
    )  # fmt: skip
    prior[ZONES + k :, ZONES + k :] = bend.stiff
    misfits, scales, found = [], [], []
    for part in parts:
        told = normal = prior
        for _ in range(steps[1] if found else steps[0]):
            log_area, slopes = zones.with_slopes(p, part)
            z = (shown - log_area) / sigma
            weight = trust(z) / sigma**2
            told = slopes.T @ (weight[:, None] * slopes)
            normal = told + prior
            step = np.linalg.solve(normal, slopes.T @ (weight * z * sigma) - prior @ (p - toward))
            step[:ZONES] = np.clip(step[:ZONES], -LONGEST_STEPS, LONGEST_STEPS)
            p = p + step
            p[0] = np.clip(p[0], np.log(COOLEST_K), np.log(HOTTEST_K))
            p[1] = np.clip(p[1], LEAST_LN_NE, MOST_LN_NE)
            p[GLOBAL:ZONES] = np.clip(p[GLOBAL:ZONES], *COOL_ENDS.T)
        z = (shown - zones.log_area(p, part)) / sigma
        say = trust(z)
        # An outlier counts as in the fit: what it adds is bounded.
        misfits.append(np.sum(z**2 * np.sqrt(say)) + (p - toward) @ prior @ (p - toward))
        # As many parameters as the lines tell, and not what is known beforehand, take their freedom.
        freedom = say.sum() - np.sum(np.linalg.inv(normal) * told)
        scales.append(_scatter(np.sum(say * z**2), freedom))
        # What is known beforehand is known as well where lines scatter less or more than they say.
        covariance = np.linalg.inv(told / scales[-1] + prior)
        own = slice(ZONES, ZONES + k)
        evidence = -0.5 * (
            misfits[-1] + np.linalg.slogdet(normal)[1] - np.linalg.slogdet(bend.stiff)[1]
        )
        found.append((p[own], covariance[own, own], float(evidence), scales[-1]))
    log_odds = -0.5 * np.array(misfits) / max(min(scales), 1.0)
    odds = np.exp(log_odds - log_odds.max())
    return [CoolPart(float(one), *of) for one, of in zip(odds / odds.sum(), found, strict=True)]


def _errors(lines: PlotLines, plot: Plot) -> FloatArray:
    """Of ln(area), (n,). A transition probability bears on it as an amount does: less in a thick line, whose
    area grows with the root of either."""
    of_probability = lines.error**2 - lines.relative**2
    return np.sqrt(lines.relative**2 + of_probability * growing(plot.kept) ** 2 + CALIBRATION**2)


def _scatter(squares: float, free: float) -> float:
    """Mean square of lines' deviations in their own errors, where they are enough to tell it; else near 1."""
    return float((squares + FEW) / (max(free, 0.0) + FEW))


@dataclass(frozen=True, slots=True, eq=False)
class _Zones:
    """Lines, (n,), of k elements, `which` of them each is of; the knot of the response before each, and which
    part of the way to the next it is."""

    lines: PlotLines
    which: IntArray
    k: int
    knot: IntArray
    far: FloatArray

    def with_slopes(self, p: FloatArray, part: float) -> tuple[FloatArray, FloatArray]:
        """ln of the lines' areas, (n,), and how they grow with each parameter, (n, p)."""
        beside = np.vstack([p, p + np.eye(len(SLOPE), len(p)) * SLOPE[:, None]])
        log_area, *more = self.log_area(beside, part)
        slopes, rows = np.zeros((len(log_area), len(p))), np.arange(len(self.lines))
        slopes[:, :ZONES] = (np.array(more) - log_area).T / SLOPE
        slopes[rows, ZONES + self.which] = 1 + slopes[:, 2]
        if len(p) > ZONES + self.k:
            slopes[rows, ZONES + self.k + self.knot] = 1 - self.far
            slopes[rows, ZONES + self.k + self.knot + 1] = self.far
        return log_area, slopes

    def log_area(self, p: FloatArray, part: float) -> FloatArray:
        """ln of the areas, (..., n), for parameters (..., p): of the hot zone's light what the cool one lets
        pass, and its own.

        Of one zone a line's area is Planck's radiance times W(tau) = tau f(tau) (`growth`), as wide as its
        zone's density makes it; the hot zone's light behind the cool one is integrated across the line.
        """
        lines, shared = self.lines, p[..., :ZONES, None]
        kelvin, density = np.exp(shared[..., 0, :]), np.exp(shared[..., 1, :])
        cooler, thinner = np.exp(shared[..., GLOBAL, :]), np.exp(shared[..., GLOBAL + 1, :])
        scale, width = p[..., ZONES + self.which], lines.width_nm * density / 1e17
        hot, cool = scale + lines.thin(
            np.stack([kelvin, cooler * kelvin])[..., 0],
            np.stack([density, thinner * density])[..., 0],
        )
        hot, cool = hot + np.log1p(-part), cool + np.log(part)
        opacity = shared[..., 2, :]
        hot_depth = opacity + hot + log_depth_of_unit(lines.vacuum_nm, width, kelvin)
        cool_depth = opacity + cool
        cool_depth += log_depth_of_unit(lines.vacuum_nm, thinner * width, cooler * kelvin)
        hot_tau, cool_tau = (
            np.exp(np.clip(d, -30, 14))[..., None] for d in (hot_depth, cool_depth)
        )
        shining = -np.expm1(-hot_tau / (1 + _SQUARE))
        passed = shining * np.exp(-cool_tau / (1 + _SQUARE / thinner[..., None] ** 2)) @ _WEIGHT
        behind = hot - hot_depth + np.log(np.maximum(passed, 1e-300))
        log_area = np.logaddexp(behind, cool + log_kept(cool_depth))
        if p.shape[-1] > ZONES + self.k:
            gain = p[..., ZONES + self.k :]
            log_area += (1 - self.far) * gain[..., self.knot] + self.far * gain[..., self.knot + 1]
        return log_area
