"""Atomic lines as arrays."""

from dataclasses import dataclass, fields

import numpy as np

from ..spectrum.spectrum import FloatArray, IntArray, TextArray


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

    def with_lines(self, more: "LineTable") -> "LineTable":
        """These and more; a line between the same levels replaces the one here."""
        there = set(more._levels())
        kept = self.where(np.array([levels not in there for levels in self._levels()]))
        both = LineTable(
            *(np.concatenate([getattr(t, name) for t in (kept, more)]) for name in COLUMNS)
        )
        both = both.where(np.argsort(both.wavelength_nm, kind="stable"))
        for name in COLUMNS:
            getattr(both, name).setflags(write=False)
        return both

    def _levels(self) -> list[tuple]:
        columns = (self.element, self.stage, self.g_i, self.g_k)
        energies = (np.round(self.e_i_ev, 3), np.round(self.e_k_ev, 3))
        return list(zip(*(column.tolist() for column in (*columns, *energies)), strict=True))

    def stark_fwhm_nm(self, temperature_k: float, density_per_cm3: float) -> FloatArray:
        """Electron-impact full widths at half maximum in nm (STARK-B), NaN where there are none."""
        log_t = np.log10(temperature_k)
        angstrom = 10 ** (self.stark_a @ np.array([1.0, log_t, log_t**2]))
        return angstrom / 10 * density_per_cm3 / self.stark_density_per_cm3


COLUMNS = tuple(field.name for field in fields(LineTable))
