"""Where the gain of the instrument jumps, by the light between the lines.

An export on one even axis shows no seam in the pitch of its channels; the continuum jumps all the
same where one detector ends and another begins, within a channel, and stays there. A line's foot
rises as fast, and comes back; a crowd of lines may look like a step, which costs little: the response
may jump there, and need not. An export cut at zero has no such light (see `steps_by_lines`).
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..spectrum.curve import median
from ..spectrum.same_axis import of_axis
from ..spectrum.spectrum import FloatArray

BLOCK_NM, LEAST_CHANNELS = 1.0, 8  # whose low quantile is the light between the lines
LOW = 0.2
NEAR, FAR = 3, 9  # blocks on either side: just beside, and where a line's foot has ended
PART = 0.2  # of the light there, that a jump must be
STAYS = 0.5  # part of the jump that is left farther away
SHARP = 8.0  # times the usual change there
MOST = 5
CUT = 0.5  # of the blocks with nothing between the lines: elsewhere there are only their feet


def gain_steps(x: FloatArray, counts: FloatArray) -> FloatArray:
    """Places of the clearest jumps, nm, ascending, at most MOST; x, counts: shape (n,), no NaN."""
    width = _width(x)
    blocks = len(x) // width
    if blocks < 2 * FAR + 2:
        return np.empty(0)
    place = int(LOW * width)
    low = np.partition(counts[: blocks * width].reshape(blocks, width), place, axis=1)[:, place]
    if np.mean(low <= 0.0) > CUT:
        return np.empty(0)
    at = np.arange(FAR, blocks - FAR + 1)
    one, two, three = low[:-2], low[1:-1], low[2:]  # NEAR of them
    near = np.maximum(np.minimum(one, two), np.minimum(np.maximum(one, two), three))
    before, after = near[at - NEAR], near[at]
    jump = after - before
    usual = float(median(np.abs(jump)))
    clear = np.abs(jump) > PART * np.maximum(np.abs(before), np.abs(after))
    clear &= np.abs(jump) > SHARP * usual
    if not clear.any():
        return np.empty(0)
    wide = _medians(low, FAR - NEAR)
    far = wide[at + NEAR] - wide[at - FAR]
    clear &= far * np.sign(jump) > STAYS * np.abs(jump)
    found: list[int] = []
    for i in np.argsort(-np.abs(jump) * clear, kind="stable"):
        if not clear[i] or len(found) == MOST:
            break
        if all(abs(at[i] - other) > FAR for other in found):
            found.append(int(at[i]))
    return np.sort([_edge(x, counts, block * width, width) for block in found])


@of_axis
def _width(x: FloatArray) -> int:
    """Channels of a block."""
    return max(int(BLOCK_NM / float(median(np.diff(x)))), LEAST_CHANNELS)


def _medians(values: FloatArray, n: int) -> FloatArray:
    """Of every n neighbours; shape (k - n + 1,)."""
    ordered = np.sort(sliding_window_view(values, n), axis=1)
    return 0.5 * (ordered[:, (n - 1) // 2] + ordered[:, n // 2])


def _edge(x: FloatArray, counts: FloatArray, near: int, width: int) -> float:
    """The channel that parts low counts from high ones best, within a block to either side."""
    own = slice(near - width, near + width)
    y = np.minimum(counts[own], 2.0 * float(median(counts[own])) + 1e-12)
    total, n = np.cumsum(y), np.arange(1, len(y) + 1)
    left, right = total[:-1] / n[:-1], (total[-1] - total[:-1]) / n[:0:-1]
    best = int(np.argmax(n[:-1] * n[:0:-1] * (right - left) ** 2))
    return float(x[near - width + best + 1])
