"""Convert the first column to nanometres, and reject one that cannot be wavelengths."""

from typing import Literal

import numpy as np

from .fault import Unreadable
from .spectrum import FloatArray

Unit = Literal["nm", "angstrom", "um"]
NM_PER: dict[str, float] = {"nm": 1.0, "angstrom": 0.1, "um": 1000.0}
SHORTEST_NM, LONGEST_NM = (
    100.0,
    3_000.0,
)  # no plasma is observed outside this range, through any window or air
USUAL_NM = 1_200.0  # limit of silicon: beyond it, steps of exactly 1 are channel numbers


def in_nm(values: FloatArray, unit: Unit = "nm") -> FloatArray:
    """Wavelengths in nm, shape (n,). Raises Unreadable if they make no sense in that unit."""
    if unit not in NM_PER:
        raise Unreadable(f"{unit!r} is not a unit of wavelength; choose one of {', '.join(NM_PER)}")
    nm = np.asarray(values, dtype=np.float64) * NM_PER[unit]
    first, last = float(np.min(nm)), float(np.max(nm))
    if first >= SHORTEST_NM and last <= USUAL_NM:
        return nm
    if _counts_channels(np.asarray(values)):
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


def _plausible(first: float, last: float, factor: float) -> bool:
    return first * factor >= SHORTEST_NM and last * factor <= LONGEST_NM


def _counts_channels(values: FloatArray) -> bool:
    return len(values) > 1 and bool(np.all(np.diff(values) == 1))
