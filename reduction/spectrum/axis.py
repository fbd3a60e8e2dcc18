"""Convert the first column to nanometres, and reject one that cannot be wavelengths."""

import re
from typing import Literal

import numpy as np

from .fault import Unreadable
from .spectrum import FloatArray

Unit = Literal["nm", "angstrom", "pm", "um", "m", "cm-1", "eV"]
NM_PER: dict[str, float] = {"nm": 1.0, "angstrom": 0.1, "pm": 1e-3, "um": 1000.0, "m": 1e9}
NM_BY_INVERSE: dict[str, float] = {"cm-1": 1e7, "eV": 1239.841984}  # vacuum wavelength times these
UNITS = (*NM_PER, *NM_BY_INVERSE)
NAMED: tuple[tuple[Unit, re.Pattern[str]], ...] = (
    ("nm", re.compile(r"\bnm\b|nano\W?met", re.I)),
    ("angstrom", re.compile(r"[åÅ\u212b]|[aA]ngstr|[(\[]A[)\]]")),
    ("pm", re.compile(r"[(\[]pm[)\]]|^pm$|pico\W?met")),  # in a sentence it is an afternoon
    ("um", re.compile(r"[µμu]m\b|micro\W?(met|n)|\bmicrons?\b", re.I)),
    ("cm-1", re.compile(r"cm\s?\^?\s?[-−⁻][1¹]|1/cm|wave\s?number", re.I)),
    ("eV", re.compile(r"\beV\b", re.I)),
    ("m", re.compile(r"[(\[]m[)\]]|^met(er|re)s?$|^m$")),
)
NO_WAVELENGTH = re.compile(r"raman|shift|frequency|\b[TG]Hz\b|\brel\W{0,2}(1/cm|cm)", re.I)
WAVELENGTH = re.compile(
    r"wave\s?len|\bw\.?v?l(\b|_)|lambda|wellenl|longueur|longitud|lunghezza|длин|波长|波長|파장|λ",
    re.I,
)
SHORTEST_NM, LONGEST_NM = (
    100.0,
    3_000.0,
)  # no plasma is observed outside this range, through any window or air
LEAST_SHIFT, USUAL_SHIFT, MOST_SHIFT = (
    -1_000.0,
    1_000.0,
    4_500.0,
)  # where Raman spectra end, in cm-1
USUAL_NM = 1_200.0  # limit of silicon: beyond it, steps of exactly 1 are channel numbers


def unit_named(words: str) -> Unit | None:
    """The unit that a heading names, None for none.

    Raises Unreadable for a quantity that is no wavelength.
    """
    if NO_WAVELENGTH.search(words):
        raise Unreadable(
            f"the axis is {words.strip()[:40]!r}, not a wavelength; export the spectrum over "
            "wavelengths in nm"
        )
    return next((unit for unit, pattern in NAMED if pattern.search(words)), None)


def in_nm(values: FloatArray, unit: Unit = "nm", said: bool = False) -> FloatArray:
    """Wavelengths in nm, shape (n,). Raises Unreadable if they make no sense in that unit.

    said: the unit, by a heading or a person, so that steps of 1 are no numbers of channels.
    """
    if unit not in UNITS:
        raise Unreadable(f"{unit!r} is not a unit of wavelength; choose one of {', '.join(UNITS)}")
    values = np.asarray(values, dtype=np.float64)
    nm = _nm(values, unit)
    first, last = float(np.min(nm)), float(np.max(nm))
    if first >= SHORTEST_NM and last <= USUAL_NM:
        return nm
    inside = first >= SHORTEST_NM and last <= LONGEST_NM
    if counts_channels(values) and not (said and inside):
        hint = "; if they are in nm, use --unit nm (unit='nm')" if inside else ""
        raise Unreadable(
            "the first column is channel numbers (..., 7, 8, 9, ...), not wavelengths; "
            f"export the spectrum with its wavelength axis{hint}"
        )
    if inside:
        return nm
    likely = [one for one in UNITS if _plausible(_nm(values, one))]
    hint = ""
    if likely:
        hint = (
            f"; if they are in {' or '.join(likely)}, say so in a heading, or use --unit {likely[0]} "
            f"(unit={likely[0]!r})"
        )
    elif np.min(values) > LEAST_SHIFT and USUAL_SHIFT < np.max(values) < MOST_SHIFT:
        hint = "; are these Raman shifts? Export the spectrum over wavelengths in nm"
    raise Unreadable(
        f"the wavelengths run from {first:g} to {last:g} nm, outside the range of any spectrum{hint}"
    )


def check_unsaid(values: FloatArray, wavelengths: bool) -> None:
    """Raise Unreadable for an axis without a unit that in nm would be beyond most detectors.

    wavelengths: it is said that it has these, so that only those beyond all usual detectors are a question.
    """
    low, high = float(np.min(values)), float(np.max(values))
    if not USUAL_NM <= high <= LONGEST_NM or counts_channels(values):
        return
    if low >= USUAL_NM:
        raise Unreadable(
            f"no heading says the unit of the wavelengths, {low:g} to {high:g}: in nm no "
            "line that is known here would be among them; say it with --unit angstrom (unit='angstrom'), "
            "or --unit nm"
        )
    if not wavelengths:
        raise Unreadable(
            f"nothing says what the axis is, from {low:g} to {high:g}: wavelengths in nm, or Raman shifts, "
            "of which nothing could be told here; if it is in nm, use --unit nm (unit='nm')"
        )


def may_be_nm(values: FloatArray) -> bool:
    """Whether these ascend and lie where spectra are, in nm."""
    inside = values[0] >= SHORTEST_NM and values[-1] <= LONGEST_NM
    return bool(inside and np.all(np.diff(values) > 0))


def _nm(values: FloatArray, unit: str) -> FloatArray:
    if unit in NM_PER:
        return values * NM_PER[unit]
    return np.divide(NM_BY_INVERSE[unit], values, out=np.zeros(len(values)), where=values > 0)


def _plausible(nm: FloatArray) -> bool:
    return bool(np.min(nm) >= SHORTEST_NM and np.max(nm) <= LONGEST_NM)


def counts_channels(values: FloatArray) -> bool:
    """Whether these are numbers of channels: each one more than the one before."""
    return len(values) > 1 and bool(np.all(np.diff(values) == 1))
