"""Ask the whole line table whether an element that is surely there made a faint peak.

The catalogue holds the strongest lines of each element; iron has thousands more, and two of the
faint ones may stand where a trace of chromium should. Only detections that rest on a few peaks
are asked.
"""

from functools import lru_cache

import numpy as np

from .catalogue import CONDITIONS
from .identify import Identified
from .spectrum import FloatArray, IntArray
from .strengths import atoms, log_strengths
from .voigt import VoigtPeaks

SAME = 0.5  # of a peak's full width: lines nearer than that are in it
ENOUGH = 0.5  # of a peak's area, that explains it: transition probabilities are known no better


def explained(identified: Identified, peaks: VoigtPeaks, which: IntArray, but: int) -> FloatArray:
    """Part of the area of each peak of `which` that other accepted elements make, shape (k,).

    but: the element that is in question. All lines of the table count, as thin ones.
    """
    others = tuple(sorted(e for e in identified.indexed.accepted if e != but))
    if not others or not len(which):
        return np.zeros(len(which))
    rows = _rows(others)
    a = atoms()
    shown = identified.offsets.shown(a.wavelength_nm[rows])
    part = np.zeros(len(which))
    kelvin, density = _state(identified)
    for n, k in enumerate(which):
        reach = max(SAME * peaks.fwhm_nm[k], identified.matched.place_error_nm)
        near = rows[np.abs(shown - peaks.centre_nm[k]) < reach]
        log = log_strengths(near, kelvin, density) + identified.indexed.log_scale[a.element[near]]
        part[n] = float(np.exp(log).sum()) / peaks.area[k]
    return part


def _state(identified: Identified) -> tuple[float, float]:
    plot = identified.plot
    return CONDITIONS[1] if plot is None else (plot.temperature_k, 10**plot.log10_ne)


@lru_cache(maxsize=32)
def _rows(elements: tuple[int, ...]) -> IntArray:
    return np.flatnonzero(np.isin(atoms().element, elements))
