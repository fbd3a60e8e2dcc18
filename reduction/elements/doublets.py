"""Detect self-absorption by doublets: two lines from nearly one upper level have a fixed ratio.

Both areas are proportional to g_k A / lambda; if the stronger is too weak relative to the weaker, it
absorbed its own light. Only ratios that theory fixes to a few per cent are used.
"""

from dataclasses import dataclass

import numpy as np

from ..lines.lines import BOLTZMANN_EV_PER_K, of_lines
from ..peaks.voigt import VoigtPeaks
from ..plasma.strengths import atoms
from .identify import Identified


@dataclass(frozen=True, slots=True)
class Doublet:
    """Stronger and weaker line, vacuum nm, of a species in the plain notation 'Na I'."""

    name: str
    element: str
    strong_nm: float
    weak_nm: float


DOUBLETS = (
    Doublet("Na I 589", "Na", 589.158, 589.756),
    Doublet("K I 767", "K", 766.701, 770.108),
    Doublet("Rb I 780", "Rb", 780.241, 794.979),
    Doublet("Cs I 852", "Cs", 852.347, 894.593),
    Doublet("Ca II 393", "Ca", 393.478, 396.959),
    Doublet("Mg II 280", "Mg", 279.635, 280.353),
    Doublet("Al I 396", "Al", 396.265, 394.512),
    Doublet("Al I 309", "Al", 309.361, 308.305),
    Doublet("Ba II 455", "Ba", 455.531, 493.545),
    Doublet("Sr II 408", "Sr", 407.886, 421.671),
)
SAME_LINE_NM, SAME_PEAK_NM = 0.03, 0.08
LOST, SURE = 0.12, 2.5  # least fraction of the light lost, and in standard errors


def self_absorbed(peaks: VoigtPeaks, identified: Identified) -> tuple[str, ...]:
    """A sentence for each doublet of a found element whose stronger line lost light."""
    names = {str(atoms().elements[e]) for e in identified.indexed.accepted}
    said = []
    for doublet in DOUBLETS:
        if doublet.element in names:
            lost = light_lost(doublet, peaks, identified)
            if lost is not None and lost[0] > max(LOST, SURE * lost[1]):
                said.append(f"{doublet.name} absorbs itself: {lost[0]:.0%} lost")
    return tuple(said)


def light_lost(
    doublet: Doublet, peaks: VoigtPeaks, identified: Identified
) -> tuple[float, float] | None:
    """Fraction of its light that the stronger line lost, relative to the weaker, and its error."""
    strong, weak = (
        _peak(doublet.strong_nm, peaks, identified),
        _peak(doublet.weak_nm, peaks, identified),
    )
    if strong is None or weak is None or strong == weak:
        return None
    kelvin = 10_000.0 if identified.plot is None else identified.plot.temperature_k
    thin = _strength(doublet, doublet.strong_nm, kelvin) / _strength(
        doublet, doublet.weak_nm, kelvin
    )
    ratio = float(peaks.area[strong] / peaks.area[weak])
    error = float(np.hypot(*(peaks.area_error[[strong, weak]] / peaks.area[[strong, weak]])))
    return 1.0 - ratio / thin, ratio / thin * error


def _peak(vacuum_nm: float, peaks: VoigtPeaks, identified: Identified) -> int | None:
    if not len(peaks):
        return None
    away = np.abs(peaks.centre_nm - identified.offsets.place(vacuum_nm))
    nearest = int(np.argmin(away))
    return nearest if away[nearest] < SAME_PEAK_NM else None


def _strength(doublet: Doublet, vacuum_nm: float, kelvin: float) -> float:
    log_ga, upper_ev = _lines(doublet.element, vacuum_nm)
    return float(np.sum(np.exp(log_ga - upper_ev / (BOLTZMANN_EV_PER_K * kelvin))))


@of_lines()
def _lines(element: str, vacuum_nm: float):
    a = atoms()
    near = np.abs(a.wavelength_nm - vacuum_nm) < SAME_LINE_NM
    near &= a.elements[a.element] == element
    return a.log_ga[near], a.e_k_ev[near]
