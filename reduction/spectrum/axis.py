"""Convert the first column to nanometres, and reject one that cannot be wavelengths."""

import re
from typing import Literal

import numpy as np

from .fault import Unreadable
from .spectrum import FloatArray

Unit = Literal["nm", "angstrom", "um"]
NM_PER: dict[str, float] = {"nm": 1.0, "angstrom": 0.1, "um": 1000.0}
NAMED: tuple[tuple[Unit, re.Pattern[str]], ...] = (
    ("nm", re.compile(r"\bnm\b|nano\W?met", re.I)),
    ("angstrom", re.compile(r"[åÅ\u212b]|[åa]ngstr|[(\[]A[)\]]")),
    ("um", re.compile(r"[µμu]m\b|micro\W?(met|n)|\bmicrons?\b", re.I)),
)
NO_WAVELENGTH = re.compile(r"cm\s?\^?\s?[-−⁻][1¹]|1/cm|wave\s?number|raman|\beV\b|\bTHz\b", re.I)
SHORTEST_NM, LONGEST_NM = (
    100.0,
    3_000.0,
)  # no plasma is observed outside this range, through any window or air
USUAL_NM = 1_200.0  # limit of silicon: beyond it, steps of exactly 1 are channel numbers


def unit_named(words: str) -> Unit | None:
    """The unit that a heading names, None for none.

    Raises Unreadable for a quantity that is no wavelength.
    """
    for unit, pattern in NAMED:
        if pattern.search(words):
            return unit
    if NO_WAVELENGTH.search(words):
        raise Unreadable(
            f"the axis is {words.strip()[:40]!r}, not a wavelength; export the spectrum over "
            "wavelengths in nm"
        )
    return None


def in_nm(values: FloatArray, unit: Unit = "nm") -> FloatArray:
    """Wavelengths in nm, shape (n,). Raises Unreadable if they make no sense in that unit."""
    if unit not in NM_PER:
        raise Unreadable(f"{unit!r} is not a unit of wavelength; choose one of {', '.join(NM_PER)}")
    nm = np.asarray(values, dtype=np.float64) * NM_PER[unit]
    first, last = float(np.min(nm)), float(np.max(nm))
    if first >= SHORTEST_NM and last <= USUAL_NM:
        return nm
    if counts_channels(np.asarray(values)):
        raise Unreadable(
            "the first column is channel numbers (..., 7, 8, 9, ...), not wavelengths; "
            "export the spectrum with its wavelength axis"
        )
    if first >= SHORTEST_NM and last <= LONGEST_NM:
        return nm
    likely = [u for u, f in NM_PER.items() if _plausible(first, last, f / NM_PER[unit])]
    hint = (
        f"; if they are in {likely[0]}, use --unit {likely[0]} (unit={likely[0]!r})"
        if likely
        else ""
    )
    raise Unreadable(
        f"the wavelengths run from {first:g} to {last:g} nm, outside the range of any spectrum{hint}"
    )


def may_be_nm(values: FloatArray) -> bool:
    """Whether these ascend and lie where spectra are, in nm."""
    inside = values[0] >= SHORTEST_NM and values[-1] <= LONGEST_NM
    return bool(inside and np.all(np.diff(values) > 0))


def _plausible(first: float, last: float, factor: float) -> bool:
    return first * factor >= SHORTEST_NM and last * factor <= LONGEST_NM


def counts_channels(values: FloatArray) -> bool:
    """Whether these are numbers of channels: each one more than the one before."""
    return len(values) > 1 and bool(np.all(np.diff(values) == 1))
