"""Lithium's share of a plasma's elements, and the share for the same light at other temperatures."""

from dataclasses import dataclass

import numpy as np

from ..spectrum.spectrum import FloatArray, IntArray
from .boltzmann import Plot, PlotLines
from .strengths import atoms

# Not counted: chamber gas, air, and anions. Their lines carry no information on cations.
NO_CATIONS = frozenset({"H", "He", "C", "N", "O", "F", "Ne", "Cl", "Ar", "Kr", "Xe"})
SPAN = 0.35  # of the temperature, to either side
N_GRID = 61


@dataclass(frozen=True, slots=True, eq=False)
class LithiumShare:
    """share of all cations whose lines are in the plot, with its standard error at the plasma's
    temperature; the same along temperature_k, with the edges that the density's error gives."""

    share: float
    share_error: float
    elements: tuple[str, ...]
    temperature_k: FloatArray
    curve: FloatArray
    low: FloatArray
    high: FloatArray


def lithium_share(lines: PlotLines, plot: Plot) -> LithiumShare | None:
    """From the Saha-Boltzmann plot, corrected for self-absorption; None if lithium is not in it.

    Each element's amount is the mean over its lines of area / (kept part * shine of one atom),
    recomputed at every temperature and density.
    """
    names = atoms().elements
    if not np.any(names[lines.element] == "Li"):
        return None
    log_thin = lines.log_area - np.log(np.maximum(plot.kept, 1e-12))
    kelvin = np.linspace(1 - SPAN, 1 + SPAN, N_GRID) * plot.temperature_k
    densities = plot.log10_ne + plot.log10_ne_error * np.array([-1.0, 0.0, 1.0])
    curves = np.array([[_share(lines, log_thin, t, 10**d) for t in kelvin] for d in densities])
    low, high = curves.min(axis=0), curves.max(axis=0)
    at = [float(np.interp(plot.temperature_k + side * plot.temperature_error_k, kelvin, curves[1]))
          for side in (-1, 0, 1)]  # fmt: skip
    by_heat = (at[2] - at[0]) / 2
    by_density = float(np.interp(plot.temperature_k, kelvin, high - low)) / 2
    by_lines = at[1] * (1 - at[1]) * _spread(lines, plot)
    error = float(np.sqrt(by_heat**2 + by_density**2 + by_lines**2))
    there = np.unique(lines.element)
    found = tuple(str(names[e]) for e in there[cations(there)])
    return LithiumShare(at[1], error, found, kelvin, curves[1], low, high)


def cations(elements: IntArray) -> np.ndarray:
    """Which of the elements (indices, any number) count."""
    return ~np.isin(atoms().elements[elements], sorted(NO_CATIONS))


def _share(lines: PlotLines, log_thin: FloatArray, kelvin: float, density: float) -> float:
    log_amount = log_thin - lines.thin(kelvin, density)
    weight = 1.0 / lines.error**2
    elements, which = np.unique(lines.element, return_inverse=True)
    mean = np.bincount(which, weight * log_amount) / np.bincount(which, weight)
    amount = np.where(cations(elements), np.exp(mean - mean.max()), 0.0)
    lithium = np.flatnonzero(atoms().elements[elements] == "Li")
    return float(amount[lithium[0]] / amount.sum())


def _spread(lines: PlotLines, plot: Plot) -> float:
    """Error of ln(amount of lithium), from how its lines scatter."""
    own = atoms().elements[lines.element] == "Li"
    one = float(np.sqrt(1.0 / np.sum(1.0 / lines.error[own] ** 2)))
    return one * max(float(np.sqrt(plot.chi2)), 1.0)
