"""Choose the representative line of an element, and find it among the fitted peaks."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ..lines.air import to_air
from ..lines.lines import lines_of, of_lines
from ..lines.usual import USUAL_LINES
from ..peaks.voigt import VoigtPeaks
from ..plasma.plasma import relative_strengths
from .hydrogen import HAlpha
from .offsets import Offsets

DEFAULT_ELEMENTS = ("Li", "K", "Si", "Na", "Al", "Ca", "Rb", "H")
SAME_LINE_NM = 0.01  # between a wavelength above and its row in the table
UNRESOLVED_NM = 0.05  # lines of a multiplet that one detector sees as one, such as Li I 670.78
TOLERANCE_NM = 0.15  # between where a line should be and where the analyser shows it

Fate = Literal["found", "no peak", "outside the spectrum"]


@dataclass(frozen=True, slots=True)
class Line:
    """The representative line of an element; its wavelength in vacuum (nm)."""

    element: str
    stage: int
    wavelength_nm: float


@dataclass(frozen=True, slots=True)
class ElementPeak:
    """The peak of one element: the area is 0, and peak None, if there is no peak.

    A broad H-alpha is fitted in a separate window and is not among the peaks either: see hydrogen.py.
    """

    line: Line
    fate: Fate
    area: float = 0.0  # counts nm
    area_error: float = 0.0  # counts nm
    peak: int | None = None  # which of the fitted peaks
    offset_nm: float | None = None  # from where the line should be to where it is seen


@of_lines()
def predominant_line(element: str) -> Line:
    """The usual analytical line of an element, else its strongest at 1 eV and 1e17 per cm3.

    The wavelength is the mean of what one detector cannot resolve, weighted by strength.
    Raises ValueError when the line table has no lines of that symbol.
    """
    lines = lines_of(element)
    strengths = relative_strengths(lines)
    if element in USUAL_LINES:
        stage, air_nm = USUAL_LINES[element]
        near = np.abs(to_air(lines.wavelength_nm) - air_nm) < SAME_LINE_NM
        best = np.argmax(np.where(near & (lines.stage == stage), strengths, -1.0))
    else:
        best = np.argmax(strengths)
    blend = np.abs(lines.wavelength_nm - lines.wavelength_nm[best]) < UNRESOLVED_NM
    blend &= lines.stage == lines.stage[best]
    mean_nm = np.average(lines.wavelength_nm[blend], weights=strengths[blend])
    return Line(element, int(lines.stage[best]), float(mean_nm))


def find_elements(
    peaks: VoigtPeaks,
    elements: Iterable[str],
    range_nm: tuple[float, float],
    offsets: Offsets | None = None,
) -> dict[str, ElementPeak]:
    """The fitted peak nearest to each element's predominant line, in the requested order.

    range_nm: first and last wavelength of the spectrum, nm. offsets: of the instrument, none in air
    if None. Raises ValueError for an element that
    the line table does not have.
    """
    asked = tuple(elements)
    found = {}
    offsets = offsets or Offsets.none("air")
    bright = np.flatnonzero(peaks.area > 0)
    centre_nm, error = peaks.centre_nm[bright], peaks.area_error[bright]
    lines = [predominant_line(element) for element in asked]
    places = [offsets.place(line.wavelength_nm) for line in lines]
    away = np.abs(centre_nm - np.array(places)[:, None])
    at_best = away.argmin(axis=1).tolist() if len(bright) else [-1] * len(asked)
    for element, line, line_nm, nearest in zip(asked, lines, places, at_best, strict=True):
        if not range_nm[0] <= line_nm <= range_nm[1]:
            found[element] = ElementPeak(line, "outside the spectrum")
            continue
        if nearest < 0 or abs(centre_nm[nearest] - line_nm) > TOLERANCE_NM:
            found[element] = ElementPeak(line, "no peak")
        else:
            at = int(bright[nearest])
            offset_nm = _offset(float(centre_nm[nearest]), line, offsets)
            found[element] = ElementPeak(
                line, "found", float(peaks.area[at]), float(error[nearest]), at, offset_nm
            )
    return found


def with_hydrogen(
    found: dict[str, ElementPeak], broad: HAlpha | None, offsets: Offsets
) -> dict[str, ElementPeak]:
    """The same with H-alpha as fitted in its wide window, if it was seen there.

    The background of the whole spectrum absorbs the wings of such a broad line, and most of its area.
    """
    if broad is None or "H" not in found:
        return found
    line = found["H"].line
    offset_nm = _offset(broad.centre_nm, line, offsets)
    whole = ElementPeak(line, "found", broad.area, broad.area_error, None, offset_nm)
    return {**found, "H": whole}


def _offset(shown_nm: float, line: Line, offsets: Offsets) -> float:
    """From where a perfect instrument would show the line."""
    return shown_nm - Offsets.none(offsets.medium).place(line.wavelength_nm)
