"""Lithium's own thermometer: the ratio of its lines at 610 and 670 nm.

For a thin plasma in equilibrium the areas follow Boltzmann: R = A610 / A670 = (gA/lambda)610 /
(gA/lambda)670 * exp(-(E610 - E670) / kT), rising with temperature. Self-absorption weakens 670
first and makes the plasma seem hotter; a Saha-Boltzmann plot is more reliable.
"""

from dataclasses import dataclass

import numpy as np

from ..lines.lines import BOLTZMANN_EV_PER_K, of_lines
from ..spectrum.spectrum import FloatArray
from .strengths import atoms

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
    """The temperature of a pair of areas (counts nm); None if no temperature gives it."""
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


@of_lines()
def _multiplet(vacuum_nm: float) -> tuple[float, float]:
    """Sum of g A / lambda of the lines at a place, and their upper level in eV."""
    a = atoms()
    near = (np.abs(a.wavelength_nm - vacuum_nm) < SAME_NM) & (a.elements[a.element] == "Li")
    near &= ~a.ion
    weight = np.exp(a.log_ga[near])
    return float(weight.sum()), float(weight @ a.e_k_ev[near] / weight.sum())
