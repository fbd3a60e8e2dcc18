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
# temperatures differ by so much of ln(T). Measured on spectra of one and two zones with all vices of
# instruments (benchmarks/intervals.py), as what makes the errors of the share right. In thick plasmas
# they differ as T itself is wrong there.
APART = 0.03
# The same of ln of any one element's amount: at all, and for each e-fold of light that its lines lost.
UNIFORM, THICK = 0.08, 0.4
HEAT_STEP = 0.01  # of ln(T), for slopes


@dataclass(frozen=True, slots=True, eq=False)
class LithiumShare:
    """share of all cations whose lines are in the plot, with its standard error, at the plasma's
    temperature."""

    share: float
    share_error: float
    elements: tuple[str, ...]


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
    error = min(share * _relative_error(lines, plot), max(share, 1.0 - share))
    there, _ = present(lines.element)
    found = tuple(str(names[e]) for e in there[cations(there)])
    return LithiumShare(share, error, found)


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


def _relative_error(lines: PlotLines, plot: Plot) -> float:
    """Error of ln(share): lines, temperature, density, self-absorption and response, in one fit,
    and of a plasma in which lithium's light and the others' are not equally hot."""
    counted = cations(plot.names)
    log_amount = np.where(counted, plot.log_scale[plot.names], -np.inf)
    parts = np.exp(log_amount - log_amount.max())
    turn = np.where(atoms().elements[plot.names] == "Li", 1.0, 0.0) - parts / parts.sum()
    fitted = max(plot.scatter * float(turn @ plot.covariance @ turn), 0.0)
    apart = plot.blind * np.hypot(APART, THICK_BY_HEAT * plot.lost)
    return float(np.sqrt(fitted + (apart * (turn @ _by_heat(lines, plot))) ** 2))


def _by_heat(lines: PlotLines, plot: Plot) -> FloatArray:
    """How ln of each element's amount, (k,), grows with ln of the temperature of its lines' light."""
    density = 10**plot.log10_ne
    warmer = lines.thin(plot.temperature_k * (1 + HEAT_STEP), density)
    slope = (lines.thin(plot.temperature_k, density) - warmer) / HEAT_STEP
    which = np.searchsorted(plot.names, lines.element)
    sure, k = 1.0 / (lines.error**2 + CALIBRATION**2), len(plot.names)
    total = np.bincount(which, sure * slope, k)
    return total / np.maximum(np.bincount(which, sure, k), 1e-12)
