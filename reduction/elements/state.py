"""The state of the plasma, from all evidence in the spectrum."""

from dataclasses import dataclass

import numpy as np

from ..peaks.voigt import VoigtPeaks
from ..plasma.lithium import ORANGE_NM, RED_NM, LithiumRatio, ratio_temperature
from ..plasma.strengths import atoms
from .doublets import self_absorbed
from .identify import Identified

SMALLEST_DENSITY = 1.6e12  # McWhirter's constant, per cm3, K^(1/2) and eV^3
GAP_EV = 4.0  # a large gap between levels of what rocks are made of (Si I, Al I, Mg II)
SAME_PLACE_NM = 0.12


@dataclass(frozen=True, slots=True)
class PlasmaState:
    """Temperature (K) and electrons (log10 per cm3) with standard errors; None where unknown.

    method: 'saha-boltzmann', 'lithium ratio' or 'h-alpha' (density alone). mcwhirter: whether the
    density allows equilibrium, None if unknown. lithium: the paper's ratio, None without its lines.
    """

    temperature_k: float | None
    temperature_error_k: float | None
    log10_ne: float | None
    log10_ne_error: float | None
    method: str
    flags: tuple[str, ...]
    mcwhirter: bool | None
    lithium: LithiumRatio | None


def mcwhirter_density(temperature_k: float, gap_ev: float = GAP_EV) -> float:
    """Electrons per cm3 above which collisions rule: 1.6e12 sqrt(T) gap^3 (McWhirter 1965)."""
    return SMALLEST_DENSITY * float(np.sqrt(temperature_k)) * gap_ev**3


def plasma_state(peaks: VoigtPeaks, identified: Identified | None) -> PlasmaState | None:
    """The state of the plasma; None if neither lines nor H-alpha determine it."""
    if identified is None:
        return None
    lithium = lithium_ratio(peaks, identified)
    flags = self_absorbed(peaks, identified)
    plot, hydrogen = identified.plot, identified.hydrogen
    density = (None, None) if hydrogen is None else (hydrogen.log10_ne, hydrogen.log10_ne_error)
    if plot is not None:
        flags = (*plot.flags, *flags)
        if not plot.density_at_bound:
            density = plot.log10_ne, plot.log10_ne_error
    if plot is not None and not plot.temperature_at_bound:
        electrons = density[0]
        enough = None if electrons is None else (
            10**electrons > mcwhirter_density(plot.temperature_k)
        )  # fmt: skip
        return PlasmaState(
            plot.temperature_k, plot.temperature_error_k, *density, "saha-boltzmann", flags,
            enough, lithium,
        )  # fmt: skip
    if lithium is not None:
        return PlasmaState(
            lithium.temperature_k, lithium.temperature_error_k, *density, "lithium ratio",
            (*flags, "two lines only"), None, lithium,
        )  # fmt: skip
    if hydrogen is not None:
        return PlasmaState(None, None, *density, "h-alpha", flags, None, None)
    return None


def lithium_ratio(peaks: VoigtPeaks, identified: Identified) -> LithiumRatio | None:
    """The ratio of the peaks at 610 and 670 nm, if lithium was found and both are present."""
    if not any(atoms().elements[e] == "Li" for e in identified.indexed.accepted):
        return None
    found = []
    for vacuum in (ORANGE_NM, RED_NM):
        at = identified.offsets.place(vacuum)
        away = np.abs(peaks.centre_nm - at)
        nearest = int(np.argmin(away)) if len(peaks) else -1
        if nearest < 0 or away[nearest] > SAME_PLACE_NM:
            return None
        found += [float(peaks.area[nearest]), float(peaks.area_error[nearest])]
    return ratio_temperature(*found)
