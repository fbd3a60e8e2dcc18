"""Identify the line of each peak: the one that contributes most, and the elements sharing it."""

from dataclasses import dataclass

import numpy as np

from ..elements.evidence import CONFOUNDS
from ..lines.air import in_medium
from ..plasma.strengths import atoms
from ..reduce import Reduction
from ..spectrum.spectrum import FloatArray, IntArray


@dataclass(frozen=True, slots=True, eq=False)
class Names:
    """For each peak, shape (k,): element ('' if no element explains it), stage, line_nm (NaN).

    line_nm: the line's wavelength in the table, in the spectrum's medium; a blend's mean. shared:
    other elements that should contribute much of the peak.
    """

    element: list[str]
    stage: IntArray
    line_nm: FloatArray
    shared: list[list[str]]


def names(reduction: Reduction) -> Names:
    """Names of the peaks, from the elements that were found."""
    k = len(reduction.peaks)
    element, stage = [""] * k, np.zeros(k, dtype=np.int64)
    line_nm, shared = np.full(k, np.nan), [[] for _ in range(k)]
    found = reduction.identified
    if found is None or not found.indexed.accepted:
        return Names(element, stage, line_nm, shared)
    known = found.catalogue
    entries = known.entries_of(found.indexed.accepted)
    entries = entries[found.matched.peak[entries] >= 0]
    peak, leader = found.matched.peak[entries], known.leader[entries]
    which = atoms().element[leader]
    share = np.exp(found.effective[entries] + found.indexed.log_scale[which])
    counts = share > CONFOUNDS * reduction.peaks.area[peak]
    nm = in_medium(found.expected.vacuum_nm[entries], reduction.medium)
    order = np.lexsort((entries, -share))
    order = order[counts[order]]
    symbols, stages = atoms().elements[which[order]].tolist(), 1 + atoms().ion[leader[order]]
    for at, name, s, i in zip(peak[order].tolist(), symbols, stages, order, strict=True):
        if not element[at]:
            element[at], line_nm[at], stage[at] = name, nm[i], s
        elif name != element[at] and name not in shared[at]:
            shared[at].append(name)
    return Names(element, stage, line_nm, shared)
