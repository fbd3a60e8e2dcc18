"""Say of each peak of a reduction which line it is, in the words of spectroscopy: 'Li I 670.8'."""

import numpy as np

from ..evidence import CONFOUNDS
from ..reduce import Reduction
from ..strengths import atoms


def peak_names(reduction: Reduction) -> list[str]:
    """A name for each peak, '' where no element that was found explains it.

    It is that of the line which should have most of the peak, and a fifth of it at least.
    """
    named = [""] * len(reduction.peaks)
    found = reduction.identified
    if found is None or not found.indexed.accepted:
        return named
    a, known = atoms(), found.catalogue
    entries = np.concatenate([
        np.arange(known.first[e], known.first[e + 1]) for e in found.indexed.accepted
    ])  # fmt: skip
    entries = entries[found.matched.peak[entries] >= 0]
    leader, peak = known.leader[entries], found.matched.peak[entries]
    share = np.exp(found.effective[entries] + found.indexed.log_scale[a.element[leader]])
    for i in np.argsort(share, kind="stable"):  # the largest comes last
        if share[i] > CONFOUNDS * reduction.peaks.area[peak[i]]:
            stage = "II" if a.ion[leader[i]] else "I"
            symbol, nm = a.elements[a.element[leader[i]]], reduction.peaks.centre_nm[peak[i]]
            named[int(peak[i])] = f"{symbol} {stage} {nm:.1f}"
    return named
