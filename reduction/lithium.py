"""Lithium's own thermometer: the ratio of its lines at 610 and 670 nm, and its fraction.

For a thin plasma in equilibrium the areas follow Boltzmann: R = A610 / A670 = (gA/lambda)610 /
(gA/lambda)670 * exp(-(E610 - E670) / kT), rising with temperature. Self-absorption weakens 670
first and makes the plasma seem hotter; the Saha-Boltzmann plot, where there is one, knows better.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from .boltzmann import Plot, PlotLines
from .boltzmann_plot import amounts
from .lines import BOLTZMANN_EV_PER_K
from .spectrum import FloatArray
from .strengths import GRID_K, atoms, ion_share

ORANGE_NM, RED_NM = 610.53, 670.96  # vacuum, means of their multiplets
SAME_NM = 0.1


@dataclass(frozen=True, slots=True)
class LithiumRatio:
    """ratio of the areas 610 / 670 and the temperature it means if the plasma is thin."""

    ratio: float
    ratio_error: float
    temperature_k: float
    temperature_error_k: float


def ratio_curve(temperature_k: FloatArray) -> FloatArray:
    """Areas 610 / 670 of a thin plasma at temperatures in K, any shape."""
    (weight_610, high), (weight_670, low) = _multiplet(ORANGE_NM), _multiplet(RED_NM)
    kt = BOLTZMANN_EV_PER_K * np.asarray(temperature_k, dtype=np.float64)
    return weight_610 / weight_670 * np.exp(-(high - low) / kt)


def ratio_temperature(
    area_610: float, error_610: float, area_670: float, error_670: float
) -> LithiumRatio | None:
    """The temperature of a pair of areas (counts nm); None where no temperature gives it."""
    if not (area_610 > 0 and area_670 > 0):
        return None
    (weight_610, high), (weight_670, low) = _multiplet(ORANGE_NM), _multiplet(RED_NM)
    ratio = area_610 / area_670
    spread = float(np.hypot(error_610 / area_610, error_670 / area_670))
    log = float(np.log(weight_610 / weight_670 / ratio))
    if log <= 0:
        return None
    kelvin = (high - low) / BOLTZMANN_EV_PER_K / log
    return LithiumRatio(ratio, ratio * spread, kelvin, kelvin * spread / log)


def lithium_fraction(
    temperature_k: FloatArray, density_per_cm3: float, area_670: float, others: float = 0.0
) -> FloatArray:
    """Share of lithium's atoms that the line at 670 nm stands for, against temperature, any shape.

    The area over what one lithium atom (of both stages) would shine: proportional to the number of
    atoms. others: the same number of all other elements; 0 gives the bare amount.
    """
    kelvin = np.atleast_1d(np.asarray(temperature_k, dtype=np.float64))
    amount = np.array([area_670 / shine(float(t), density_per_cm3) for t in kelvin])
    return amount if not others else amount / (amount + others)


@dataclass(frozen=True, slots=True, eq=False)
class LithiumFraction:
    """Atoms of lithium among those of all elements of the plot, 0 to 1, with standard errors.

    temperature_k: shape (t,), at which it would be fraction, shape (t,). at_plasma: at the plasma's
    own temperature; at_plasma_error: from the temperature, the density and lithium's areas. It is a
    ratio of what shines: elements without a line in the spectrum (often oxygen) are not in it, and
    it is no mass fraction.
    """

    temperature_k: FloatArray
    fraction: FloatArray
    at_plasma: float
    at_plasma_error: float


def lithium_fraction_curve(
    lines: PlotLines, plot: Plot, temperature_k: FloatArray | None = None
) -> LithiumFraction | None:
    """Lithium's fraction against temperature (K, shape (t,)); None without lithium in the plot."""
    own = atoms().elements[lines.element] == "Li"
    if not own.any():
        return None
    density = 10**plot.log10_ne
    kelvin = np.asarray([] if temperature_k is None else temperature_k, dtype=np.float64)
    curve = np.array([_fraction(lines, plot, float(t), density) for t in kelvin])
    here = _fraction(lines, plot, plot.temperature_k, density)
    hotter = _fraction(lines, plot, plot.temperature_k + plot.temperature_error_k, density)
    denser = _fraction(lines, plot, plot.temperature_k, density * 10**plot.log10_ne_error)
    by_area = here * (1.0 - here) / np.sqrt(np.sum(1.0 / lines.error[own] ** 2))
    error = float(np.sqrt((hotter - here) ** 2 + (denser - here) ** 2 + by_area**2))
    return LithiumFraction(kelvin, curve, here, error)


def _fraction(lines: PlotLines, plot: Plot, temperature_k: float, density: float) -> float:
    log, names = amounts(lines, plot, temperature_k, density)
    atoms_of = np.exp(log - log.max())
    return float(atoms_of[atoms().elements[names] == "Li"].sum() / atoms_of.sum())


def shine(temperature_k: float, density_per_cm3: float) -> float:
    """Thin area of Li I 670 for one atom of lithium in the plasma, arbitrary unit."""
    a = atoms()
    place = int(np.flatnonzero(a.elements == "Li")[0])
    weight, energy = _multiplet(RED_NM)
    u = np.exp(np.interp(temperature_k, GRID_K, a.log_u[place, 0]))
    neutral = 1.0 - float(ion_share(temperature_k, density_per_cm3)[place])
    return float(weight * neutral / u * np.exp(-energy / (BOLTZMANN_EV_PER_K * temperature_k)))


@cache
def _multiplet(vacuum_nm: float) -> tuple[float, float]:
    """Sum of g A / lambda of the lines at a place, and their upper level in eV."""
    a = atoms()
    near = (np.abs(a.wavelength_nm - vacuum_nm) < SAME_NM) & (a.elements[a.element] == "Li")
    near &= ~a.ion
    weight = np.exp(a.log_ga[near])
    return float(weight.sum()), float(weight @ a.e_k_ev[near] / weight.sum())
