"""Lithium's share of a plasma's elements, and the share for the same light at other temperatures."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..lines.lines import of_lines
from ..spectrum.spectrum import FloatArray, IntArray
from .boltzmann import CALIBRATION, Plot, PlotLines
from .boltzmann import THICK as THICK_BY_HEAT
from .strengths import atoms, present

# Not counted: chamber gas, air, and anions. Their lines carry no information on cations.
NO_CATIONS = frozenset((
    "H", "He", "C", "N", "O", "F", "Ne", "Cl", "Ar", "Br", "Kr", "I", "Xe",
))  # fmt: skip
SPAN = 0.35  # of the temperature, to either side
N_GRID = 61
# What one zone in equilibrium lacks: elements shine brightest in different parts of the plasma, whose
# temperatures differ by so much of ln(T), lithium's from all others'; in thick plasmas as T itself is wrong
# there, and each element's from each other's by so much if the thicker lines lost all of their light, else by
# the part that they lost (a cool shell takes light of some, and gives some of its own to others). Measured on
# spectra of one and two zones with all vices of instruments (benchmarks/intervals.py), as what makes the
# errors of the share right.
APART, EACH = 0.02, 0.08
# The same of ln of any one element's amount: at all, and for each e-fold of light that its lines lost.
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


def lithium_share(lines: PlotLines, plot: Plot) -> LithiumShare | None:
    """From the Saha-Boltzmann plot, corrected for self-absorption; None if lithium is not in it,
    or the temperature is not told: the share would go with it.

    Each element's amount is the mean over its lines of area / (kept part * shine of one atom),
    recomputed at every temperature and density.
    """
    names = atoms().elements
    if plot.temperature_at_bound or not np.any(names[lines.element] == "Li"):
        return None
    share = _share(lines, plot, plot.temperature_k, 10**plot.log10_ne)
    by = float(np.exp(min(_logit_error(lines, plot), MOST_LOGIT)))
    odds = share / max(1.0 - share, 1e-12)
    low, high = odds / (odds + by), odds / (odds + 1.0 / by)
    there, _ = present(lines.element)
    found = tuple(str(names[e]) for e in there[cations(there)])
    return LithiumShare(share, 0.5 * (high - low), found, low, high)


def share_curve(lines: PlotLines, plot: Plot) -> ShareCurve:
    """The same light at other temperatures. Lithium must be in the plot."""
    kelvin = np.linspace(1 - SPAN, 1 + SPAN, N_GRID) * plot.temperature_k
    densities = plot.log10_ne + plot.log10_ne_error * np.array([-1.0, 0.0, 1.0])
    curves = np.array([[_share(lines, plot, t, 10**d) for t in kelvin] for d in densities])
    return ShareCurve(kelvin, curves[1], curves.min(axis=0), curves.max(axis=0))


def cations(elements: IntArray) -> np.ndarray:
    """Which of the elements (indices, any number) count."""
    return _counts()[elements]


@of_lines()
def _counts() -> np.ndarray:
    return ~np.isin(atoms().elements, sorted(NO_CATIONS))


def _share(lines: PlotLines, plot: Plot, kelvin: float, density: float) -> float:
    log_kept = np.log(np.maximum(plot.kept, 1e-12))
    log_amount = lines.log_area - log_kept - lines.thin(kelvin, density)
    weight = 1.0 / lines.error**2
    elements, which = present(lines.element)
    mean = np.bincount(which, weight * log_amount) / np.bincount(which, weight)
    amount = np.where(cations(elements), np.exp(mean - mean.max()), 0.0)
    lithium = np.flatnonzero(atoms().elements[elements] == "Li")
    return float(amount[lithium[0]] / amount.sum())


def _logit_error(lines: PlotLines, plot: Plot) -> float:
    """Error of ln(share / (1 - share)): lines, temperature, density, self-absorption and response, in one
    fit, and of a plasma in which lithium's light and the others' are not equally hot."""
    lithium = atoms().elements[plot.names] == "Li"
    others = cations(plot.names) & ~lithium
    if not others.any():
        return MOST_LOGIT
    log_amount = np.where(others, plot.log_scale[plot.names], -np.inf)
    parts = np.exp(log_amount - log_amount.max())
    turn = lithium - parts / parts.sum()
    heat = turn * _by_heat(lines, plot)
    apart = plot.blind**2 * (APART**2 + (THICK_BY_HEAT * plot.lost) ** 2) * heat.sum() ** 2
    each = (plot.blind * EACH * plot.lost) ** 2 * np.sum(heat**2)
    return float(np.sqrt(max(turn @ plot.by_scatter @ turn, 0.0) + apart + each))


def _by_heat(lines: PlotLines, plot: Plot) -> FloatArray:
    """How ln of each element's amount, (k,), grows with ln of the temperature of its lines' light."""
    density = 10**plot.log10_ne
    warmer = lines.thin(plot.temperature_k * (1 + HEAT_STEP), density)
    slope = (lines.thin(plot.temperature_k, density) - warmer) / HEAT_STEP
    which = np.searchsorted(plot.names, lines.element)
    sure, k = 1.0 / (lines.error**2 + CALIBRATION**2), len(plot.names)
    total = np.bincount(which, sure * slope, k)
    return total / np.maximum(np.bincount(which, sure, k), 1e-12)
