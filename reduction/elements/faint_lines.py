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
    reach = np.maximum(SAME * peaks.fwhm_nm[which], identified.matched.place_error_nm)
    centre = peaks.centre_nm[which]
    ends = np.searchsorted(
        a.wavelength_nm, [centre - reach - FURTHEST_NM, centre + reach + FURTHEST_NM]
    )
    near = np.concatenate([np.arange(*own) for own in ends.T.tolist()] or [np.empty(0, np.int64)])
    peak = np.repeat(np.arange(len(which)), ends[1] - ends[0])
    away = np.abs(identified.offsets.shown(a.wavelength_nm[near]) - centre[peak])
    own = others[a.element[near]] & (away < reach[peak])
    near, peak = near[own], peak[own]
    log = log_strengths(near, *_state(identified)) + identified.indexed.log_scale[a.element[near]]
    return np.bincount(peak, np.exp(log), len(which)) / peaks.area[which]


def _state(identified: Identified) -> tuple[float, float]:
    plot = identified.plot
    return CONDITIONS[1] if plot is None else (plot.temperature_k, 10**plot.log10_ne)
