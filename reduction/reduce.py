"""Reduce one spectrum: channels, background, peaks, elements, plasma; one file per step."""

from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from .elements.elements import (
    DEFAULT_ELEMENTS,
    ElementPeak,
    find_elements,
    predominant_line,
    with_hydrogen,
)
from .elements.evidence import Evidence, beyond_chance, evidence
from .elements.far_off import IN_GAS, SOLID, shifts
from .elements.identify import Identified, identify
from .elements.index import ENOUGH
from .elements.offsets import FURTHEST_NM, Offsets
from .elements.state import PlasmaState, plasma_state
from .lines.lines import of_lines
from .peaks.pitch import fit_at_pitch
from .peaks.profiles import Profiles
from .peaks.voigt import VoigtPeaks
from .spectrum.bad import BadChannels, bridged, mark_bad
from .spectrum.noise import cut_off
from .spectrum.resampled import resampled
from .spectrum.response import KnownResponse
from .spectrum.spectrum import FloatArray, Medium, Spectrum

FIRST_LINE_NM, LAST_LINE_NM = 190.0, 961.0  # of the line table
FAR_OFF_NM = 0.1  # an offset that is worth a word
LITTLE, LEAST_BRIGHT, BRIGHT = 0.1, 4, 10.0  # of that light; peaks of so many errors: worth a word
BETTER, LEAST_WEIGHT = 1.5, 60.0  # evidence with a moved axis: times that without, and at least
# ln of the odds that its lines agree against chance, which has tried 401 shifts in two media: 1 in 1,000.
BEYOND_CHANCE = float(np.log(2 * 401 * 1_000))


@dataclass(frozen=True, slots=True, eq=False)
class Reduction:
    """The results of one spectrum.

    peaks: all fitted peaks, ascending. elements: the predominant peak of each requested element,
    in that order. evidence: the evidence for every element, by symbol. plasma: temperature and
    density, None if they cannot be determined. medium: of the wavelengths. profiles, bad and
    identified: intermediate results, for figures. averaged: how many channels of the spectrum were
    averaged into one, usually 1; `profiles.wavelength_nm` is the axis that was used, `bad` refers
    to the original channels. notes: sentences about what was done to this spectrum. response: by which
    the counts had been divided, None if they were as they are.
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
    response: KnownResponse | None = None

    @property
    def temperature_k(self) -> float | None:
        """Plasma temperature, None if the spectrum does not determine it."""
        return None if self.plasma is None else self.plasma.temperature_k

    @property
    def offsets(self) -> Offsets:
        """The axis offset that was used: none without an element to show it."""
        found = self.identified
        return Offsets.none(self.medium) if found is None else _trusted(found, self.medium)

    @property
    def areas(self) -> dict[str, float]:
        """Area of each element's predominant peak in counts nm, 0 if there is none."""
        return {element: found.area for element, found in self.elements.items()}

    @property
    def offsets_nm(self) -> dict[str, float | None]:
        """Offset of each element's predominant peak from its line, None if there is none."""
        return {element: found.offset_nm for element, found in self.elements.items()}

    @property
    def detected(self) -> list[str]:
        """Symbols of the detected elements, most certain first."""
        sure = [found for found in self.evidence.values() if found.status == "detected"]
        return [found.element for found in sorted(sure, key=lambda found: -found.score)]

    @property
    def n_peaks(self) -> int:
        return len(self.peaks)

    def to_dict(self) -> dict[str, Any]:
        """The results as plain numbers, with the names of the contract `spectrum_reducer@1`."""
        return {
            "areas": self.areas,
            "offsets": self.offsets_nm,
            "temperature": self.temperature_k,
            "n_peaks": self.n_peaks,
        }


def reduce_spectrum(
    spectrum: Spectrum, elements: Iterable[str] | None = None, medium: Medium | None = None
) -> Reduction:
    """Find, fit and identify the peaks of a spectrum, and determine the state of the plasma.

    elements: symbols whose predominant peak is wanted, DEFAULT_ELEMENTS if None. medium: of the
    instrument's wavelengths; decided by the lines if None. A peak must exceed five times the noise,
    or three times at the predominant line of a requested element. An axis that is far off is
    moved, with a note, where that explains the spectrum. Raises ValueError for an element
    without lines in the table and for a spectrum without a good channel.
    """
    asked = DEFAULT_ELEMENTS if elements is None else tuple(elements)
    found = _reduced(spectrum, asked, medium)
    if _explained(found) >= ENOUGH or not len(found.peaks):
        return found
    least, best = max(BETTER * _weight(found), LEAST_WEIGHT), found
    for common in (SOLID, IN_GAS):
        moved = shifts(spectrum.wavelength_nm, found.peaks, common)
        x = spectrum.wavelength_nm + moved
        if np.abs(moved).max() <= FURTHEST_NM or np.any(np.diff(x) <= 0):
            continue
        other = _reduced(replace(spectrum, wavelength_nm=x), asked, medium)
        if _weight(other) >= max(least, _weight(best)) and _agrees(other):
            note = _moved(spectrum.wavelength_nm, moved)
            best = replace(other, notes=(note, *other.notes))
    return replace(best, notes=(*best.notes, *_unexplained(best)))


def _unexplained(found: Reduction) -> tuple[str, ...]:
    """A word where hardly any of the light belongs to an element: of no plasma, or of a wrong axis."""
    peaks, part = found.peaks, _explained(found)
    if part >= LITTLE or np.count_nonzero(peaks.area > BRIGHT * peaks.area_error) < LEAST_BRIGHT:
        return ()
    return (
        f"the elements found explain {part:.0%} of the light of the strongest peaks: are the wavelengths "
        "in nm and calibrated, and is this the light of a plasma?",
    )


def _agrees(found: Reduction) -> bool:
    """Whether more lines agree in place and area than any shift would bring about by chance."""
    lines = found.identified
    return lines is not None and beyond_chance(lines, found.peaks) >= BEYOND_CHANCE


def _weight(found: Reduction) -> float:
    return 0.0 if found.identified is None else found.identified.indexed.total


def _explained(found: Reduction) -> float:
    """The part of the strongest peaks' light that the elements found explain."""
    return 0.0 if found.identified is None else found.identified.indexed.explained(found.peaks.area)


def _moved(x: FloatArray, moved: FloatArray) -> str:
    ends = np.flatnonzero(np.diff(moved)) + 1
    parts = [
        f"{by[0]:+.2f} nm from {own[0]:.1f} to {own[-1]:.1f} nm"
        for own, by in zip(np.split(x, ends), np.split(moved, ends), strict=True)
    ]
    return (
        "the wavelengths are far off; by the strongest lines of common elements they were moved "
        f"{', '.join(parts)}, and are given so: calibrate the spectrometer"
    )


def _reduced(spectrum: Spectrum, asked: tuple[str, ...], medium: Medium | None) -> Reduction:
    x, known = spectrum.wavelength_nm, spectrum.divided_by
    if known is not None:  # noise, and channels that are full, are of counts, not of light
        spectrum = replace(spectrum, intensity=spectrum.intensity * known.at(x))
    shared = noise_shared(spectrum.intensity)
    bad = mark_bad(spectrum.intensity, alone=shared == 1)
    profiles, averaged = fit_at_pitch(spectrum, bad, wanted_nm(asked, medium), shared)
    if known is not None:
        profiles = profiles.over(known)
    identified = identify(profiles.wavelength_nm, profiles.bad, profiles, medium)
    offsets = Offsets.none(medium or "air") if identified is None else _trusted(identified, medium)
    range_nm = (float(x[0]), float(x[-1]))
    broad = None if identified is None else identified.hydrogen
    found = with_hydrogen(find_elements(profiles.peaks, asked, range_nm, offsets), broad, offsets)
    said = {} if identified is None else evidence(identified, profiles.peaks)
    plasma = plasma_state(profiles.peaks, identified)
    return Reduction(profiles.peaks, found, said, plasma, offsets.medium, profiles, bad, identified,
        averaged, (
            *spectrum.notes, *_notes(x, averaged, shared, profiles),
            *_of_instrument(spectrum.intensity, offsets),
        ), known,
    )  # fmt: skip


@of_lines(64)
def wanted_nm(asked: tuple[str, ...], medium: Medium | None) -> FloatArray:
    """Possible wavelengths of the elements' predominant lines, nm, ascending, shape (k,)."""
    from .lines.air import to_air

    vacuum = np.sort([predominant_line(element).wavelength_nm for element in asked])
    if medium == "vacuum":
        return vacuum
    return to_air(vacuum) if medium == "air" else np.sort(np.concatenate([to_air(vacuum), vacuum]))


def noise_shared(intensity: FloatArray) -> int:
    """Like `resampled`, for counts (n,) that may contain NaN or infinite channels."""
    missing = ~np.isfinite(intensity)
    if missing.all():
        return 1
    return resampled(bridged(intensity, missing))


def _notes(x: FloatArray, averaged: int, shared: int, profiles: Profiles) -> tuple[str, ...]:
    notes = []
    if averaged > 1:
        why = (
            "many peaks were narrower than a line can be, as single photons are in an intensified camera"
            if profiles.spikes
            else "the lines are much wider than a channel"
            if shared == 1
            else "the noise shows that the channels were interpolated"
        )
        notes.append(f"{averaged} channels at a time were averaged into one: {why}")
    if x[-1] < FIRST_LINE_NM or x[0] > LAST_LINE_NM:
        notes.append(
            f"from {x[0]:g} to {x[-1]:g} nm the line table has no lines "
            f"({FIRST_LINE_NM:g} to {LAST_LINE_NM:g} nm); are the wavelengths in nm?"
        )
    if not len(profiles.peaks):
        notes.append("no peak stands out of the noise; were the right columns read?")
    return tuple(notes)


def _of_instrument(intensity: FloatArray, offsets: Offsets) -> tuple[str, ...]:
    """What was noticed of counts and axis, and allowed for."""
    notes = []
    finite = np.isfinite(intensity)
    counts = intensity if finite.all() else intensity[finite]
    cut = np.count_nonzero(cut_off(counts))
    if cut:
        notes.append(
            f"{cut} channels have the lowest value, {np.min(counts):g}: the counts were cut off "
            "there, and the noise was taken from the others"
        )
    low, high = float(offsets.offset_nm.min()), float(offsets.offset_nm.max())
    if max(-low, high) > FAR_OFF_NM:
        notes.append(
            f"lines are shown {low:+.2f} to {high:+.2f} nm from where they should be, differently "
            "along the axis; they were sought there"
        )
    return tuple(notes)


def _trusted(identified: Identified, medium: Medium | None) -> Offsets:
    """The offsets, if an element was found with them; else those of a perfect instrument."""
    if identified.indexed.accepted:
        return identified.offsets
    return Offsets.none(medium or "air")
