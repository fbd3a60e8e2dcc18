"""Reduce one spectrum: channels, background, peaks, elements, plasma; each step has its own file."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from .bad import BadChannels, bridged, mark_bad
from .elements import DEFAULT_ELEMENTS, ElementPeak, find_elements, predominant_line, with_hydrogen
from .evidence import Evidence, evidence
from .identify import Identified, identify
from .offsets import Offsets
from .pitch import fit_at_pitch
from .profiles import Profiles
from .resampled import resampled
from .spectrum import FloatArray, Medium, Spectrum
from .state import PlasmaState, plasma_state
from .voigt import VoigtPeaks

FIRST_LINE_NM, LAST_LINE_NM = 190.0, 961.0  # of the line table


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """What one spectrum says.

    peaks: all that were fitted, ascending. elements: the predominant peak of each element asked
    for, in that order. evidence: what speaks for every element, by symbol. plasma: temperature and
    density, None where nothing tells. medium: what the wavelengths are counted in. profiles, bad
    and identified are the steps' own results, for figures. averaged: how many channels of the
    spectrum were taken as one, 1 for most; `profiles.wavelength_nm` is the axis that was used, `bad`
    is of the spectrum's own channels. notes: sentences about what was done to this spectrum.
    """

    peaks: VoigtPeaks
    elements: dict[str, ElementPeak]
    evidence: dict[str, Evidence]
    plasma: PlasmaState | None
    medium: Medium
    profiles: Profiles
    bad: BadChannels
    identified: Identified | None = field(default=None)
    averaged: int = 1
    notes: tuple[str, ...] = ()

    @property
    def temperature_k(self) -> float | None:
        """Of the plasma, None where the spectrum does not tell."""
        return None if self.plasma is None else self.plasma.temperature_k

    @property
    def areas(self) -> dict[str, float]:
        """Area of each element's predominant peak in counts nm, 0 where there is none."""
        return {element: found.area for element, found in self.elements.items()}

    @property
    def offsets_nm(self) -> dict[str, float | None]:
        """How far each element's predominant peak is from its place, None where there is none."""
        return {element: found.offset_nm for element, found in self.elements.items()}

    @property
    def detected(self) -> list[str]:
        """Symbols of the elements that are surely there, surest first."""
        sure = [found for found in self.evidence.values() if found.status == "detected"]
        return [found.element for found in sorted(sure, key=lambda found: -found.score)]

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
    spectrum: Spectrum, elements: Iterable[str] | None = None, medium: Medium | None = None
) -> Reduction:
    """Find, fit and name the peaks of a spectrum, and say what the plasma was.

    elements: symbols whose predominant peak is wanted, DEFAULT_ELEMENTS if None. medium: what the
    instrument's wavelengths are counted in; decided by the lines if None. Peaks stand out five
    times of the noise; at the predominant lines of the elements asked for, three times is enough.
    Raises ValueError for an element without lines in the table and for a spectrum without a good
    channel.
    """
    asked = DEFAULT_ELEMENTS if elements is None else tuple(elements)
    x = spectrum.wavelength_nm
    shared = noise_shared(spectrum.intensity)
    bad = mark_bad(spectrum.intensity, alone=shared == 1)
    profiles, averaged = fit_at_pitch(spectrum, bad, wanted_nm(asked, medium), shared)
    identified = identify(profiles.wavelength_nm, profiles.bad, profiles, medium)
    offsets = Offsets.none(medium or "air") if identified is None else _trusted(identified, medium)
    range_nm = (float(x[0]), float(x[-1]))
    broad = None if identified is None else identified.hydrogen
    found = with_hydrogen(find_elements(profiles.peaks, asked, range_nm, offsets), broad, offsets)
    said = {} if identified is None else evidence(identified, profiles.peaks)
    plasma = plasma_state(profiles.peaks, identified)
    return Reduction(profiles.peaks, found, said, plasma, offsets.medium, profiles, bad, identified,
        averaged, _notes(x, averaged, shared),
    )  # fmt: skip


@lru_cache(maxsize=64)
def wanted_nm(asked: tuple[str, ...], medium: Medium | None) -> FloatArray:
    """Where the predominant lines of the elements may be seen, nm, ascending, shape (k,)."""
    from .air import to_air

    vacuum = np.sort([predominant_line(element).wavelength_nm for element in asked])
    if medium == "vacuum":
        return vacuum
    return to_air(vacuum) if medium == "air" else np.sort(np.concatenate([to_air(vacuum), vacuum]))


def noise_shared(intensity: FloatArray) -> int:
    """As `resampled`, of counts (n,) that may have channels without a number."""
    missing = ~np.isfinite(intensity)
    if missing.all():
        return 1
    return resampled(bridged(intensity, missing))


def _notes(x: FloatArray, averaged: int, shared: int) -> tuple[str, ...]:
    notes = []
    if averaged > 1:
        why = (
            "lines are far wider"
            if shared == 1
            else "their noise shows that they were interpolated"
        )
        notes.append(f"{averaged} channels at a time were averaged into one: {why}")
    if x[-1] < FIRST_LINE_NM or x[0] > LAST_LINE_NM:
        notes.append(
            f"from {x[0]:g} to {x[-1]:g} nm the line table has no lines "
            f"({FIRST_LINE_NM:g} to {LAST_LINE_NM:g} nm); are the wavelengths in nm?"
        )
    return tuple(notes)


def _trusted(identified: Identified, medium: Medium | None) -> Offsets:
    """The offsets, if an element was found by them; else those of a perfect instrument."""
    if identified.indexed.accepted:
        return identified.offsets
    return Offsets.none(medium or "air")
