"""Lithium's share of a plasma's elements, and the share for the same light at other temperatures."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..lines.lines import of_lines
from ..spectrum.spectrum import FloatArray, IntArray
from .boltzmann import CALIBRATION, Bend, Plot, PlotLines
from .cool_part import PARTS, CoolPart, cool_parts
from .strengths import atoms, present

# Not counted: chamber gas, air, and anions. Their lines carry no information on cations.
NO_CATIONS = frozenset((
    "H", "He", "C", "N", "O", "F", "Ne", "Cl", "Ar", "Br", "Kr", "I", "Xe",
))  # fmt: skip
SPAN = 0.35  # of the temperature, to either side
N_GRID = 61
# What one zone in equilibrium lacks: elements shine brightest in different parts of the plasma, whose
# temperatures differ by so much of ln(T), lithium's from all others'. Measured on spectra with all vices of
# instruments (benchmarks/intervals.py), as what makes the errors of the share right.
APART = 0.02
# Where thicker lines lost more than this part of their light, it matters whether there is a cool shell, which
# one zone and a bent response hide: two zones are fitted, with these parts of the atoms cool, in a few steps.
COOL_FROM, FEW_PARTS, FEW_STEPS = 0.2, PARTS[:6:2], (2, 2)
# What one zone lacks of ln of any one element's amount: at all, and for each e-fold that its lines lost.
UNIFORM, THICK = 0.08, 0.4
HEAT_STEP = 0.01  # of ln(T), for slopes
MOST_LOGIT = 12.0  # nothing is told


@dataclass(frozen=True, slots=True, eq=False)
class LithiumShare:
    """share of all cations whose lines are in the plot, at the plasma's temperature, with its standard error.

    low, high: one standard error of logit(share) to either side, which keeps them within 0 to 1;
    share_error: half of what is between them.
    """

    share: float
    share_error: float
    elements: tuple[str, ...]
    low: float
    high: float


class ShareCurve(NamedTuple):
    """The share along the temperature, with the edges that the density's error gives; shape (n,)."""

    temperature_k: FloatArray
    share: FloatArray
    low: FloatArray
    high: FloatArray


def lithium_share(lines: PlotLines, plot: Plot, bend: Bend) -> LithiumShare | None:
    """From the Saha-Boltzmann plot, corrected for self-absorption; None if lithium is not in it,
    or the temperature is not told: the share would go with it.

    Each element's amount is the mean over its lines of area / (kept part * shine of one atom),
    recomputed at every temperature and density; in a thick plasma that of two zones. bend: what was known
    of the response beforehand.
    """
    names = atoms().elements
    if plot.temperature_at_bound or not np.any(names[lines.element] == "Li"):
        return None
    log_odds, error = _log_odds(lines, plot, bend)
    error = min(error, MOST_LOGIT)
    low, share, high = _share_of(log_odds + error * np.array([-1.0, 0.0, 1.0])).tolist()
    there, _ = present(lines.element)
    found = tuple(str(names[e]) for e in there[cations(there)])
    return LithiumShare(share, 0.5 * (high - low), found, low, high)


def share_curve(lines: PlotLines, plot: Plot, bend: Bend) -> ShareCurve:
    """The same light at other temperatures. Lithium must be in the plot."""
    kelvin = np.linspace(1 - SPAN, 1 + SPAN, N_GRID) * plot.temperature_k
    ln_ne = plot.log10_ne + plot.log10_ne_error * np.array([-1.0, 0.0, 1.0])
    at = np.array([[_of_one_zone(lines, plot, t, 10**d) for t in kelvin] for d in ln_ne])
    here, _ = _log_odds(lines, plot, bend)
    curves = _share_of(at + here - _of_one_zone(lines, plot, plot.temperature_k, 10**plot.log10_ne))
    return ShareCurve(kelvin, curves[1], curves.min(axis=0), curves.max(axis=0))


def cations(elements: IntArray) -> np.ndarray:
    """Which of the elements (indices, any number) count."""
    return _counts()[elements]


@of_lines()
def _counts() -> np.ndarray:
    return ~np.isin(atoms().elements, sorted(NO_CATIONS))


def _share_of(log_odds: FloatArray) -> FloatArray:
    return 1.0 / (1.0 + np.exp(-log_odds))


def _of_one_zone(lines: PlotLines, plot: Plot, kelvin: float, density: float) -> float:
    """ln(share / (1 - share))."""
    log_kept = np.log(np.maximum(plot.kept, 1e-12))
    log_amount = lines.log_area - log_kept - lines.thin(kelvin, density)
    weight = 1.0 / lines.error**2
    elements, which = present(lines.element)
    mean = np.bincount(which, weight * log_amount) / np.bincount(which, weight)
    amount = np.where(cations(elements), np.exp(mean - mean.max()), 0.0)
    lithium = atoms().elements[elements] == "Li"
    return float(np.log(amount[lithium][0] / max(amount[~lithium].sum(), 1e-12)))


def _log_odds(lines: PlotLines, plot: Plot, bend: Bend) -> tuple[float, float]:
    """ln(share / (1 - share)), and its error: lines, temperature, density, self-absorption and response, in
    one fit, and of a plasma in which lithium's light and the others' are not equally hot."""
    middle = _of_one_zone(lines, plot, plot.temperature_k, 10**plot.log10_ne)
    if np.count_nonzero(cations(plot.names)) < 2:
        return middle, MOST_LOGIT
    _, turn = _turn(plot.names, plot.log_scale[plot.names])
    variance = turn @ plot.by_scatter @ turn
    if plot.lost > COOL_FROM:
        parts = cool_parts(lines, plot, bend, FEW_PARTS, FEW_STEPS)
        middle, variance = _of_zones(plot.names, parts)
    apart = plot.blind * APART * (turn @ _by_heat(lines, plot))
    return middle, float(np.sqrt(max(variance, 0.0) + apart**2))


def _of_zones(names: IntArray, parts: list[CoolPart]) -> tuple[float, float]:
    """The mean of ln(share / (1 - share)) over all parts, by how likely they are, and its variance."""
    turned = [_turn(names, part.log_scale) for part in parts]
    each = np.array([log_odds for log_odds, _ in turned])
    own = [turn @ part.covariance @ turn for part, (_, turn) in zip(parts, turned, strict=True)]
    likely = np.array([part.evidence for part in parts])
    likely = np.exp((likely - likely.max()) / max(min(part.scatter for part in parts), 1.0))
    middle = np.average(each, weights=likely)
    return float(middle), float(np.average(own + (each - middle) ** 2, weights=likely))


def _turn(names: IntArray, log_amount: FloatArray) -> tuple[float, FloatArray]:
    """ln(share / (1 - share)) of ln of the amounts, (k,), and how it grows with each."""
    lithium = atoms().elements[names] == "Li"
    log_amount = np.where(cations(names), log_amount, -np.inf)
    parts = np.where(lithium, 0.0, np.exp(log_amount - log_amount[~lithium].max()))
    others = log_amount[~lithium].max() + np.log(parts.sum())
    return float(log_amount[lithium][0] - others), lithium - parts / parts.sum()


def _by_heat(lines: PlotLines, plot: Plot) -> FloatArray:
    """How ln of each element's amount, (k,), grows with ln of the temperature of its lines' light."""
    density = 10**plot.log10_ne
    warmer = lines.thin(plot.temperature_k * (1 + HEAT_STEP), density)
    slope = (lines.thin(plot.temperature_k, density) - warmer) / HEAT_STEP
    which = np.searchsorted(plot.names, lines.element)
    sure, k = 1.0 / (lines.error**2 + CALIBRATION**2), len(plot.names)
    total = np.bincount(which, sure * slope, k)
    return total / np.maximum(np.bincount(which, sure, k), 1e-12)
