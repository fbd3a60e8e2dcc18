"""Line strengths of a plasma in local thermodynamic equilibrium (Saha, Boltzmann)."""

import numpy as np

from ..lines.lines import BOLTZMANN_EV_PER_K, LOWERING_EV, LineTable, partition_function, species
from ..spectrum.spectrum import FloatArray

TYPICAL_TEMPERATURE_K = 11_600.0  # 1 eV, a microsecond after the pulse
TYPICAL_DENSITY_PER_CM3 = 1e17
# 2 (2 pi m_e k / h^2)^(3/2), per cm3 and K^(3/2)
SAHA_PER_CM3 = 4.829e15


def saha_ratio(element: str, temperature_k: float, density_per_cm3: float) -> float:
    """Ions per neutral atom, no unit.

    n_II / n_I = 4.829e15 T^1.5 / n_e * U_II / U_I * exp(-(E_ion - lowering) / kT)
    (Griem, Plasma Spectroscopy, 1964). Raises ValueError for an unknown element.
    """
    neutral = partition_function(element, 1, temperature_k)
    ion = _ion_partition_function(element, temperature_k)
    cost_ev = species(element, 1).ionisation_ev - LOWERING_EV
    boltzmann = np.exp(-cost_ev / (BOLTZMANN_EV_PER_K * temperature_k))
    return float(SAHA_PER_CM3 * temperature_k**1.5 / density_per_cm3 * ion / neutral * boltzmann)


def relative_strengths(
    lines: LineTable,
    temperature_k: float = TYPICAL_TEMPERATURE_K,
    density_per_cm3: float = TYPICAL_DENSITY_PER_CM3,
) -> FloatArray:
    """Power per atom of each line of one element, stages I and II, in eV/s; shape (n,).

    Optically thin: share of the stage * A g_k / U(T) * exp(-E_k / kT) * photon energy.
    Raises ValueError when the lines are of more elements than one.
    """
    names = np.unique(lines.element)
    if len(names) != 1:
        raise ValueError(f"the lines must be of one element, not of {', '.join(names) or 'none'}")
    element = str(names[0])
    ratio = saha_ratio(element, temperature_k, density_per_cm3)
    share = np.where(lines.stage == 1, 1.0, ratio) / (1.0 + ratio)
    total = np.where(
        lines.stage == 1,
        partition_function(element, 1, temperature_k),
        _ion_partition_function(element, temperature_k),
    )
    occupied = lines.g_k / total * np.exp(-lines.e_k_ev / (BOLTZMANN_EV_PER_K * temperature_k))
    return share * lines.a_ki_per_s * occupied * (lines.e_k_ev - lines.e_i_ev)


def _ion_partition_function(element: str, temperature_k: float) -> float:
    return 1.0 if element == "H" else partition_function(element, 2, temperature_k)  # a bare proton
