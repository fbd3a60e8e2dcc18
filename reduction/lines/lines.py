"""Look up atomic lines, levels and ionisation energies in the shipped table.

The table is compiled from the NIST Atomic Spectra Database; data/SOURCES.md says how.
Its wavelengths are vacuum wavelengths.
"""

from dataclasses import dataclass, fields
from functools import cache
from importlib.resources import files
from io import BytesIO

import numpy as np

from ..spectrum.spectrum import FloatArray, IntArray, TextArray

BOLTZMANN_EV_PER_K = 8.617333262e-5
# Debye lowering of the ionisation energy at 1 eV and 1e17 electrons per cm3,
# e^2 / (4 pi eps0 lambda_D) with lambda_D = 23.5 nm; levels above it are not bound.
LOWERING_EV = 0.06


@dataclass(frozen=True, slots=True, eq=False)
class LineTable:
    """Arrays of equal length N, one row per line, ascending in wavelength.

    `stage` is 1 for a neutral atom (I) and 2 for a single ion (II); `i` is the lower level of
    a line and `k` the upper. `accuracy` is the class NIST gives the transition probability.
    """

    element: TextArray
    stage: IntArray
    wavelength_nm: FloatArray
    a_ki_per_s: FloatArray
    g_i: FloatArray
    g_k: FloatArray
    e_i_ev: FloatArray
    e_k_ev: FloatArray
    accuracy: TextArray
    stark_density_per_cm3: FloatArray
    stark_a: FloatArray

    def __len__(self) -> int:
        return len(self.wavelength_nm)

    def where(self, chosen: np.ndarray) -> "LineTable":
        """The rows that a mask or an array of indices chooses."""
        return LineTable(*(getattr(self, name)[chosen] for name in COLUMNS))

    def stark_fwhm_nm(self, temperature_k: float, density_per_cm3: float) -> FloatArray:
        """Electron-impact full widths at half maximum in nm (STARK-B), NaN where there are none."""
        log_t = np.log10(temperature_k)
        angstrom = 10 ** (self.stark_a @ np.array([1.0, log_t, log_t**2]))
        return angstrom / 10 * density_per_cm3 / self.stark_density_per_cm3


COLUMNS = tuple(field.name for field in fields(LineTable))


@dataclass(frozen=True, slots=True, eq=False)
class Species:
    """The levels of one element in one stage of ionisation, energies ascending."""

    ionisation_ev: float
    level_ev: FloatArray
    level_g: FloatArray


@cache
def _arrays() -> dict[str, np.ndarray]:
    packed = files("labrun.reduction.data").joinpath("lines.npz").read_bytes()
    with np.load(BytesIO(packed), allow_pickle=False) as table:
        arrays = {name: table[name] for name in table.files}
    for array in arrays.values():
        array.setflags(write=False)
    return arrays


@cache
def line_table() -> LineTable:
    """All 29,833 lines, read once; the arrays are read-only."""
    arrays = _arrays()
    return LineTable(*(arrays[name] for name in COLUMNS))


@cache
def lines_of(element: str) -> LineTable:
    """The lines of one element, stages I and II.

    Raises ValueError when the table has none of that symbol.
    """
    table = line_table()
    found = table.where(table.element == element)
    if not len(found):
        raise ValueError(f"the line table has no lines of {element!r}")
    return found


@cache
def species(element: str, stage: int) -> Species:
    """The levels and ionisation energy (eV) of an element in stage 1 (I) or 2 (II).

    Raises ValueError when the table has no such species.
    """
    arrays = _arrays()
    same = (arrays["species_element"] == element) & (arrays["species_stage"] == stage)
    if not same.any():
        raise ValueError(f"the line table has no levels of {element!r} in stage {stage}")
    index = int(np.flatnonzero(same)[0])
    levels = slice(*arrays["level_offset"][index : index + 2])
    return Species(
        float(arrays["species_ionisation_ev"][index]),
        arrays["level_ev"][levels],
        arrays["level_g"][levels],
    )


def partition_function(
    element: str, stage: int, temperature_k: float, lowering_ev: float = LOWERING_EV
) -> float:
    """Sum of g exp(-E / kT) over the levels below the lowered ionisation energy, no unit."""
    found = species(element, stage)
    bound = found.level_ev < found.ionisation_ev - lowering_ev
    energies, weights = found.level_ev[bound], found.level_g[bound]
    return float(np.sum(weights * np.exp(-energies / (BOLTZMANN_EV_PER_K * temperature_k))))
