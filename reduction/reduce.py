"""Reduce one spectrum: noise, spikes, background, peaks, profiles, elements."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .background import background, despike
from .elements import (
    DEFAULT_ELEMENTS,
    PRESENT,
    ElementPeak,
    expected_nm,
    find_elements,
    near_lines,
)
from .noise import local_noise
from .peaks import find_peaks
from .spectrum import Medium, Spectrum
from .voigt import VoigtPeaks, fit_peaks


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """What one spectrum says.

    peaks: all that were fitted. elements: what was found of each element asked for, in that order.
    temperature_k: of the plasma, None where the spectrum does not tell.
    """

    peaks: VoigtPeaks
    elements: dict[str, ElementPeak]
    temperature_k: float | None = None

    @property
    def areas(self) -> dict[str, float]:
        """Area of each element's predominant peak in counts nm, 0 where there is none."""
        return {element: found.area for element, found in self.elements.items()}

    @property
    def offsets_nm(self) -> dict[str, float | None]:
        """How far each element's predominant peak is from its place, None where there is none."""
        return {element: found.offset_nm for element, found in self.elements.items()}

    @property
    def n_peaks(self) -> int:
        return len(self.peaks)

    def to_dict(self) -> dict[str, Any]:
        """The figures as plain numbers, in the words of the contract `spectrum_reducer@1`."""
        return {
            "areas": self.areas,
            "offsets": self.offsets_nm,
            "temperature": self.temperature_k,
            "n_peaks": self.n_peaks,
        }


def reduce_spectrum(
    spectrum: Spectrum, elements: Iterable[str] | None = None, medium: Medium = "air"
) -> Reduction:
    """Find and fit the peaks of a spectrum, and say which of them stands for which element.

    elements: symbols, DEFAULT_ELEMENTS if None. medium: what the instrument's wavelengths are
    counted in. Peaks stand out five times of the noise; at the predominant lines of the elements
    asked for, three times is enough. The temperature is not estimated yet. Raises ValueError for
    an element without lines in the table and for a spectrum without a good channel.
    """
    asked = DEFAULT_ELEMENTS if elements is None else tuple(elements)
    lines_nm = expected_nm(asked, medium)
    whole = spectrum.without_bad()
    wavelength_nm = whole.wavelength_nm
    noise = local_noise(whole.intensity)
    calm = Spectrum(wavelength_nm, despike(whole.intensity, noise))
    net = calm.intensity - background(calm, noise)

    weak = find_peaks(net, noise, significant=PRESENT)
    wanted = weak[near_lines(wavelength_nm[weak], lines_nm)]
    channels = np.union1d(find_peaks(net, noise), wanted)

    peaks = fit_peaks(wavelength_nm, net, noise, channels)
    range_nm = (float(wavelength_nm[0]), float(wavelength_nm[-1]))
    return Reduction(peaks, find_elements(peaks, asked, range_nm, medium))
