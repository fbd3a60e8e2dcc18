"""Several shots on one axis: kept one by one, or averaged into one spectrum."""

from dataclasses import dataclass

import numpy as np

from .spectrum import FloatArray, Spectrum


@dataclass(frozen=True, slots=True, eq=False)
class Shots:
    """wavelength_nm: shape (n,), ascending. intensity: shape (shots, n), counts; NaN is bad.

    notes: what was noticed while the file was read, as sentences.
    """

    wavelength_nm: FloatArray
    intensity: FloatArray
    notes: tuple[str, ...] = ()

    def __len__(self) -> int:
        return len(self.intensity)

    def each(self) -> list[Spectrum]:
        """One spectrum per shot."""
        return [Spectrum(self.wavelength_nm, counts, self.notes) for counts in self.intensity]

    def mean(self) -> Spectrum:
        """The average of the shots; a channel that is bad in some is the mean of the others."""
        if len(self) == 1:
            return Spectrum(self.wavelength_nm, self.intensity[0], self.notes)
        good = np.isfinite(self.intensity)
        total = np.where(good, self.intensity, 0.0).sum(axis=0)
        count = good.sum(axis=0)
        mean = np.divide(total, count, out=np.full(len(total), np.nan), where=count > 0)
        return Spectrum(self.wavelength_nm, mean, (*self.notes, f"the mean of {len(self)} shots"))
