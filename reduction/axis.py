"""Make nanometres of the first column, and refuse one that cannot be wavelengths."""

from typing import Literal

import numpy as np

from .fault import Unreadable
from .spectrum import FloatArray

Unit = Literal["nm", "angstrom", "um"]
NM_PER: dict[str, float] = {"nm": 1.0, "angstrom": 0.1, "um": 1000.0}
SHORTEST_NM, LONGEST_NM = 100.0, 3_000.0  # no plasma is looked at beyond, through no window or air
USUAL_NM = 1_200.0  # what silicon sees: beyond it, steps of exactly 1 are channels


def in_nm(values: FloatArray, unit: Unit = "nm") -> FloatArray:
    """Wavelengths in nm, shape (n,). Raises Unreadable when they make no sense in that unit."""
    if unit not in NM_PER:
        raise Unreadable(f"{unit!r} is no unit of wavelength; it is one of {', '.join(NM_PER)}")
    nm = np.asarray(values, dtype=np.float64) * NM_PER[unit]
    first, last = float(np.min(nm)), float(np.max(nm))
    if first >= SHORTEST_NM and last <= USUAL_NM:
        return nm
    if _counts_channels(np.asarray(values)):
        raise Unreadable(
            "the first column counts channels (..., 7, 8, 9, ...) and is no wavelength; "
            "export the spectrum with its wavelength axis"
        )
    if first >= SHORTEST_NM and last <= LONGEST_NM:
        return nm
    likely = [u for u, f in NM_PER.items() if _plausible(first, last, f / NM_PER[unit])]
    hint = (
        f"; if they are in {likely[0]}, say --unit {likely[0]} (unit={likely[0]!r})"
        if likely
        else ""
    )
    raise Unreadable(
        f"the wavelengths run from {first:g} to {last:g} nm, which no spectrum does{hint}"
    )


def _plausible(first: float, last: float, factor: float) -> bool:
    return first * factor >= SHORTEST_NM and last * factor <= LONGEST_NM


def _counts_channels(values: FloatArray) -> bool:
    return len(values) > 1 and bool(np.all(np.diff(values) == 1))
