"""Estimate the instrument's wavelength offset along the axis, and whether it is in air or vacuum.

Every pair of a peak and a possible line votes for the distance between them. The
votes of a stretch of the axis are a histogram; the offset may jump between stretches (a new
detector) but each change has a cost, and the path of least cost through all of them (Viterbi, IEEE
Trans. Inf. Theory 13, 260 (1967)) is the estimate. It is found for air and for vacuum; the medium
with more votes is chosen.
"""

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np

from ..lines.air import in_medium
from ..lines.air_kernel import in_air
from ..spectrum.kernel import inner_kernel, kernel, part_kernel
from ..spectrum.same_axis import of_axis
from ..spectrum.spectrum import FloatArray, Medium

FURTHEST_NM = 0.26
STEP_NM = 0.01
STRETCH_NM = 30.0
CHANGE = 0.4  # what a change by one step costs, in votes
JUMP = 2.0  # what any change costs at most
SEEN_JUMP = 0.5  # and where the axis itself has a seam
MOST_SEAMS = 12
SEAM = 0.02  # change of the channels' pitch, as a part of it, that is a seam
HALF = round(FURTHEST_NM / STEP_NM)  # steps to either side
USUAL_NM = 0.08  # offsets beyond are rare


@dataclass(frozen=True, slots=True, eq=False)
class Offsets:
    """shown = true + offset. edges_nm: between stretches, (k - 1,); offset_nm: in them, (k,).

    votes: how well lines and peaks agree; more is better.
    """

    medium: Medium
    edges_nm: FloatArray
    offset_nm: FloatArray
    votes: float

    @classmethod
    def none(cls, medium: Medium) -> "Offsets":
        """Those of an instrument without errors."""
        return cls(medium, np.empty(0), np.zeros(1), 0.0)

    def at(self, shown_nm: FloatArray) -> FloatArray:
        """Offset in nm at places on the axis, those of their stretches; any shape."""
        return self.offset_nm[np.searchsorted(self.edges_nm, shown_nm, side="right")]

    def shown(self, vacuum_nm: FloatArray) -> FloatArray:
        """Expected positions of lines on the axis, nm; any shape."""
        true = in_medium(vacuum_nm, self.medium)
        return true + self.at(true)

    def place(self, vacuum_nm: float) -> float:
        """Expected position of one line on the axis, nm."""
        true = in_air(vacuum_nm) if self.medium == "air" else vacuum_nm
        return float(true + self.offset_nm[bisect_right(self.edges_nm, true)])


def estimate_offsets(
    peak_nm: FloatArray,
    peak_weight: FloatArray,
    line_vacuum_nm: FloatArray,
    line_weight: FloatArray,
    medium: Medium | None,
    blur_nm: float,
    stretch_nm: float = STRETCH_NM,
    seams_nm: FloatArray | None = None,
) -> list[Offsets]:
    """Offsets along the axis. peak_nm: ascending; weights: votes; medium None: to be decided.

    blur_nm: how well a peak's centre is known. seams_nm: where one detector ends and the next
    begins. The best comes first; two of them where the medium is to be decided.
    """
    media: tuple[Medium, ...] = ("air", "vacuum") if medium is None else (medium,)
    edges = _edges(peak_nm, stretch_nm, seams_nm)
    jump = np.full(len(edges) - 1, JUMP)
    if seams_nm is not None and len(seams_nm):
        jump[np.isin(edges[:-1], seams_nm)] = SEEN_JUMP
    order = np.argsort(line_vacuum_nm)  # in air the same
    vacuum_nm, weight = line_vacuum_nm[order], line_weight[order]
    found = []
    for m in media:
        path, total = _agreed(
            peak_nm, peak_weight, in_medium(vacuum_nm, m), weight, edges, jump, blur_nm
        )
        found.append(Offsets(m, edges[1:-1], (path - HALF) * STEP_NM, total))
    return sorted(found, key=lambda offsets: -offsets.votes)


@of_axis
def seams(x: FloatArray) -> FloatArray:
    """Where the pitch of the channels changes abruptly, as between detectors; nm, ascending."""
    pitch = np.diff(x)
    if len(pitch) < 8:
        return np.empty(0)
    # Over two channels, so that a wavelength rounded to few digits is not taken for a seam.
    before, after = x[4:-4] - x[:-8], x[8:] - x[4:-4]
    turn = np.abs(np.log(after / before))
    over = np.flatnonzero(turn > SEAM)
    if not len(over):
        return np.empty(0)
    runs = np.split(over, np.flatnonzero(np.diff(over) > 8) + 1)
    if len(runs) > MOST_SEAMS:
        return np.empty(0)
    # A long run: the channels of two detectors, sorted into each other where they overlap.
    found = [[run[np.argmax(turn[run])]] if len(run) <= 16 else [run[0], run[-1]] for run in runs]
    return x[4 + np.concatenate(found)]


def _edges(peak_nm: FloatArray, stretch_nm: float, seams_nm: FloatArray | None) -> FloatArray:
    first, last = float(peak_nm[0]), float(peak_nm[-1]) + 1e-6
    n = max(round((last - first) / stretch_nm), 1)
    edges = np.linspace(first, last, n + 1)
    if seams_nm is None or not len(seams_nm):
        return edges
    inside = seams_nm[(seams_nm > first) & (seams_nm < last)]
    return np.unique(np.concatenate([edges, inside]))


@kernel
def _agreed(peak, weight, line, line_weight, edges, jump, blur):
    """The offset of each stretch, in steps from the first, and all its votes."""
    votes = np.empty((len(edges) - 1, 2 * HALF + 1))
    for s in range(2 * HALF + 1):
        away = (s - HALF) * STEP_NM / USUAL_NM
        for stretch in range(len(votes)):
            votes[stretch, s] = -0.5 * away * away / len(votes)
    _vote(peak, weight, line, line_weight, edges, blur, votes)
    return _cheapest(votes, CHANGE, jump)


@part_kernel
def _vote(peak, weight, line, line_weight, edges, blur, votes):
    m, half = 2 * HALF + 1, HALF
    begin, stretch = 0, 0
    best = np.zeros(m)
    for k in range(len(peak)):
        while stretch < len(votes) - 1 and edges[stretch + 1] <= peak[k]:
            stretch += 1
        while begin < len(line) and line[begin] < peak[k] - FURTHEST_NM - 3 * blur:
            begin += 1
        best.fill(0.0)
        i = begin
        while i < len(line) and line[i] < peak[k] + FURTHEST_NM + 3 * blur:
            away = peak[k] - line[i]
            first = int(np.ceil((away - 3 * blur) / STEP_NM)) + half
            last = int(np.floor((away + 3 * blur) / STEP_NM)) + half
            for s in range(max(first, 0), min(last, m - 1) + 1):
                z = (away - (s - half) * STEP_NM) / blur
                best[s] = max(best[s], line_weight[i] * np.exp(-0.5 * z * z))
            i += 1
        for s in range(m):
            votes[stretch, s] += weight[k] * best[s]


@part_kernel
def _cheapest(votes, change, jump):
    """The path of most votes; a change by s steps costs change * s, and a jump at the most."""
    n, m = votes.shape
    total = votes[0].copy()
    came = np.zeros((n, m), np.int64)
    following = np.empty(m)
    for b in range(1, n):
        highest = _highest(total)
        at = 0
        for s in range(m):  # the best that comes from below, or from the same
            at = s if total[s] >= total[at] - change * (s - at) else at
            following[s], came[b, s] = total[at] - change * (s - at), at
        at = m - 1
        for s in range(m - 1, -1, -1):  # or from above
            at = s if total[s] >= total[at] - change * (at - s) else at
            if total[at] - change * (at - s) > following[s]:
                following[s], came[b, s] = total[at] - change * (at - s), at
        for s in range(m):  # or from anywhere
            if total[highest] - jump[b] > following[s]:
                following[s], came[b, s] = total[highest] - jump[b], highest
        for s in range(m):
            total[s] = following[s] + votes[b, s]
    path = np.zeros(n, np.int64)
    path[n - 1] = _highest(total)
    for b in range(n - 1, 0, -1):
        path[b - 1] = came[b, path[b]]
    return path, total[path[n - 1]]


@inner_kernel
def _highest(values):
    """Where the first of the highest is: as np.argmax, which takes three times as long to compile."""
    at = 0
    for i in range(1, len(values)):
        if values[i] > values[at]:
            at = i
    return at
