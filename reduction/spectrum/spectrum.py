"""A spectrum: ascending wavelengths in nm, and as many intensities in counts."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from .response import KnownResponse

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.integer]
BoolArray = NDArray[np.bool_]
TextArray = NDArray[np.str_]
# The medium of the instrument's wavelengths; atomic lines are tabulated in vacuum.
Medium = Literal["air", "vacuum"]


@dataclass(frozen=True, slots=True, eq=False)
class Spectrum:
    """One measured spectrum.

    wavelength_nm: shape (n,), strictly ascending. intensity: shape (n,), counts; NaN marks a
    bad channel. notes: what was noticed while it was read, as sentences. divided_by: the response by
    which the counts were divided, if they were. Raises ValueError if wavelengths and intensities do not
    match or there is no channel.
    """

    wavelength_nm: FloatArray
    intensity: FloatArray
    notes: tuple[str, ...] = ()
    divided_by: "KnownResponse | None" = None

    def __post_init__(self) -> None:
        if self.wavelength_nm.shape != self.intensity.shape or self.wavelength_nm.ndim != 1:
            raise ValueError(
                f"{self.wavelength_nm.shape} wavelengths do not match "
                f"{self.intensity.shape} intensities; both must have the same length"
            )
        if not len(self.wavelength_nm):
            raise ValueError("a spectrum needs at least one channel")
        if not np.all(self.wavelength_nm[1:] > self.wavelength_nm[:-1]):
            raise ValueError("the wavelengths of a spectrum must ascend")

    def __len__(self) -> int:
        return len(self.wavelength_nm)

    def without_bad(self) -> "Spectrum":
        """The spectrum with bad channels bridged by straight lines."""
        bad = np.isnan(self.intensity)
        if not bad.any():
            return self
        if bad.all():
            raise ValueError("every channel of the spectrum is bad (NaN)")
        good = ~bad
        bridged = np.interp(self.wavelength_nm, self.wavelength_nm[good], self.intensity[good])
        return replace(self, intensity=bridged)

    def _repr_html_(self) -> str:
        from .svg import as_svg

        return as_svg(self)
