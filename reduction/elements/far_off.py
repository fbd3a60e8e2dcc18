"""Axes that are so far off that no line is where it is sought, as of a spectrometer never calibrated.

Each detector's strongest peaks vote for a shift, by the strongest lines of what rocks and metals are made
of. The votes alone prove nothing: whoever applies the shifts looks whether they explain the spectrum.
"""

from itertools import pairwise

import numpy as np

from ..lines.air import to_air
from ..lines.lines import lines_of, of_lines
from ..peaks.voigt import VoigtPeaks
from ..plasma.plasma import relative_strengths
from ..spectrum.spectrum import FloatArray

FURTHEST_NM, STEP_NM, BLUR_NM = 4.0, 0.02, 0.06
GAP = 25.0  # usual pitches without a channel: another detector begins
PEAKS, LINES = 20, 5  # strongest of a detector, and of an element in its range
LEAST_PEAKS = 4
SOLID = ("H", "Li", "O", "Na", "Mg", "Al", "Si", "K", "Ca", "Ti", "Fe", "Cu", "Zn")
IN_GAS = (*SOLID, "N", "Ar")  # where the chamber's gas shines, too


def shifts(x: FloatArray, peaks: VoigtPeaks, elements: tuple[str, ...]) -> FloatArray:
    """How much to add to each channel's wavelength, nm, shape (n,): what most of the strongest peaks
    of its detector agree on, 0 where these are too few."""
    found = np.zeros(len(x))
    grid = np.arange(-FURTHEST_NM, FURTHEST_NM + STEP_NM / 2, STEP_NM)
    for own in _detectors(x):
        inside = (peaks.centre_nm >= x[own][0]) & (peaks.centre_nm <= x[own][-1])
        bright = np.flatnonzero(inside & (peaks.area > 0))
        bright = bright[np.argsort(-peaks.area[bright])][:PEAKS]
        lines = _lines(round(float(x[own][0])), round(float(x[own][-1])), elements)
        if len(bright) < LEAST_PEAKS or not len(lines):
            continue
        weight = np.sqrt(peaks.area[bright])
        off = lines[None, :, None] - peaks.centre_nm[bright][:, None, None] - grid
        votes = weight @ np.exp(-0.5 * (off / BLUR_NM) ** 2).max(axis=1)
        found[own] = grid[int(np.argmax(votes))]
    return found


def _detectors(x: FloatArray) -> list[slice]:
    step = np.diff(x)
    ends = np.flatnonzero(step > GAP * np.median(step)) + 1
    edges = [0, *ends.tolist(), len(x)]
    return [slice(a, b) for a, b in pairwise(edges)]


@of_lines(32)
def _lines(first_nm: int, last_nm: int, elements: tuple[str, ...]) -> FloatArray:
    """The strongest lines of these elements in a range, nm in air."""
    found = []
    for element in elements:
        lines = lines_of(element)
        shown, strength = to_air(lines.wavelength_nm), relative_strengths(lines)
        inside = np.flatnonzero((shown > first_nm - FURTHEST_NM) & (shown < last_nm + FURTHEST_NM))
        found.append(shown[inside[np.argsort(-strength[inside])][:LINES]])
    return np.concatenate(found)
