"""The area of each element's predominant peak: one and the same line in every spectrum.

The line is the usual analytical one where it is seen nearly as often as any other, else the one
that is seen most often, and among those the brightest. Where nothing stands at its place, the area
is 0; a spectrum that was not reduced has none (NaN).
"""

from dataclasses import dataclass

import numpy as np

from ...lines.usual import USUAL_LINES
from ...spectrum.spectrum import FloatArray
from .reduced import Records, Reduced

SAME_LINE_NM = 0.05  # between rows of one line in the tables of several spectra
USUAL_NM = 0.35  # from a line in air to where an instrument in vacuum, and off, may show it
NEARLY = 0.5  # part of the spectra that the most frequent line has
LEAST_TOLERANCE_NM = 0.05


@dataclass(frozen=True, slots=True, eq=False)
class Predominant:
    """One line of an element; area and area_error in counts nm, shape (spectra,)."""

    line_nm: float
    area: FloatArray
    area_error: FloatArray


def predominant_peaks(reduced: Reduced) -> dict[str, Predominant]:
    """The predominant peak of every element that has one in any of the spectra."""
    tables = [table for table in (reduced.elements, reduced.peaks) if table is not None]
    named = sorted({
        str(name)
        for table in tables
        for name in np.unique(table.element[np.nan_to_num(table.area) > 0])
        if name
    })  # fmt: skip
    found = {name: _of(reduced, name) for name in named}
    return {name: one for name, one in found.items() if one is not None}


def _of(reduced: Reduced, element: str) -> Predominant | None:
    n = len(reduced.spectra)
    area, error = np.full(n, np.nan), np.full(n, np.nan)
    line_nm, told = None, np.zeros(n, dtype=bool)
    if reduced.elements is not None:
        line_nm = _line(reduced.elements, element)
        if line_nm is not None:
            told = _take(reduced.elements, element, line_nm, area, error)
    if reduced.peaks is not None:
        line_nm = _line(reduced.peaks, element) if line_nm is None else line_nm
        if line_nm is not None:
            _from_peaks(reduced.peaks, element, line_nm, told, area, error)
    if line_nm is None:
        return None
    area[reduced.failed] = error[reduced.failed] = np.nan
    return Predominant(line_nm, area, error)


def _line(table: Records, element: str) -> float | None:
    """Where the predominant line of an element stands in a table, nm; None without an area."""
    own = (table.element == element) & (np.nan_to_num(table.area) > 0)
    own &= np.isfinite(table.line_nm)
    if not own.any():
        return None
    order = np.argsort(table.line_nm[own], kind="stable")
    line, area = table.line_nm[own][order], table.area[own][order]
    which = np.concatenate([[0], np.cumsum(np.diff(line) > SAME_LINE_NM)])
    seen, bright = np.bincount(which), np.bincount(which, area)
    place = np.bincount(which, line) / seen
    often = seen >= NEARLY * seen.max()
    if element in USUAL_LINES:
        away = np.abs(place - USUAL_LINES[element][1])
        if np.any(often & (away < USUAL_NM)):
            return float(place[np.argmin(np.where(often, away, np.inf))])
    return float(place[np.argmax(np.where(often, bright, -1.0))])


def _take(table: Records, element: str, line_nm: float, area: FloatArray, error: FloatArray):
    """Areas of the rows that speak of the line; which spectra have such a row."""
    own = (table.element == element) & (np.abs(table.line_nm - line_nm) < USUAL_NM)
    own &= np.isfinite(table.area)
    area[table.at[own]], error[table.at[own]] = table.area[own], table.area_error[own]
    told = np.zeros(len(area), dtype=bool)
    told[table.at[own]] = True
    return told


def _from_peaks(peaks: Records, element: str, line_nm: float, told, area, error) -> None:
    """Areas where the elements' table is silent, errors everywhere."""
    own = (peaks.element == element) & (np.abs(peaks.line_nm - line_nm) < USUAL_NM)
    centre = float(np.median(peaks.centre_nm[own])) if own.any() else line_nm
    spread = float(np.std(peaks.centre_nm[own])) if own.any() else 0.0
    free = (peaks.element == element) | (peaks.element == "")
    # An axis that is off moves its lines by less than a few hundredths from spectrum to spectrum.
    near = np.abs(peaks.centre_nm - centre) < max(LEAST_TOLERANCE_NM, 3.0 * spread)
    chosen = np.flatnonzero(free & near & np.isfinite(peaks.area))
    chosen = chosen[np.argsort(peaks.area[chosen], kind="stable")]  # the largest comes last
    at = peaks.at[chosen]
    reduced = np.unique(peaks.at)
    silent = reduced[~told[reduced]]
    area[silent] = 0.0
    best = np.full(len(area), -1)
    best[at] = chosen
    fill = ~told & (best >= 0)
    area[fill] = peaks.area[best[fill]]
    same = best >= 0
    same[same] = np.abs(peaks.area[best[same]] - area[same]) <= 1e-4 * np.abs(area[same])
    error[same] = peaks.area_error[best[same]]
