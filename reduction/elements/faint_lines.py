"""Check in the whole line table whether an accepted element explains a faint peak.

The catalogue holds the strongest lines of each element; iron has thousands more, and two of the
faint ones may coincide with the lines of a trace of chromium. Only detections that rest on a few
peaks are checked.
"""

import numpy as np

from ..peaks.voigt import VoigtPeaks
from ..plasma.strengths import atoms, log_strengths
from ..spectrum.spectrum import FloatArray, IntArray
from .catalogue import CONDITIONS
from .identify import Identified

FURTHEST_NM = 0.6  # between a vacuum wavelength and where it is seen: air and offset
SAME = 0.5  # of a peak's full width: lines nearer than that are in it
ENOUGH = 0.5  # of a peak's area, that explains it: transition probabilities are known no better


def explained(identified: Identified, peaks: VoigtPeaks, which: IntArray, but: int) -> FloatArray:
    """Part of the area of each peak of `which` that other accepted elements make, shape (k,).

    but: the element that is in question. All lines of the table count, as thin ones.
    """
    a = atoms()
    others = np.zeros(len(a.elements), dtype=bool)
    others[identified.indexed.accepted] = True
    others[but] = False
    kelvin, density = _state(identified)
    part = np.zeros(len(which))
    fwhm_nm = peaks.fwhm_nm
    for n, k in enumerate(which):
        centre = float(peaks.centre_nm[k])
        reach = max(SAME * float(fwhm_nm[k]), identified.matched.place_error_nm)
        ends = centre + np.array([-1.0, 1.0]) * (reach + FURTHEST_NM)
        near = np.arange(*np.searchsorted(a.wavelength_nm, ends))
        near = near[others[a.element[near]]]
        near = near[np.abs(identified.offsets.shown(a.wavelength_nm[near]) - centre) < reach]
        if len(near):
            log = (
                log_strengths(near, kelvin, density) + identified.indexed.log_scale[a.element[near]]
            )
            part[n] = float(np.exp(log).sum()) / peaks.area[k]
    return part


def _state(identified: Identified) -> tuple[float, float]:
    plot = identified.plot
    return CONDITIONS[1] if plot is None else (plot.temperature_k, 10**plot.log10_ne)
