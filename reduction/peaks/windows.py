"""Estimate each peak's width, group it with its neighbours, and choose the channels to fit.

Peaks whose feet overlap are fitted together; the channels of a group end where the next group's
peak begins to rise.
"""

import numpy as np

from ..spectrum.kernel import inner_kernel, kernel

REACH = 3.0  # half-window beyond the outer peaks, in full widths at half maximum
TOGETHER = 1.5  # peaks closer than this many of their summed widths share a fit
MOST_TOGETHER = 8  # the cost grows with the cube
LEAST_CHANNELS = 6  # on either side of a peak


@inner_kernel
def half_heights(y, at):
    """Channels (with fraction) from a peak to half its height on its left, and on its right."""
    # A constant for the direction would be a type of its own for numba, and compiled for each.
    left, right = 0.0, 0.0
    for direction in (-1, 1):
        left, right = right, _half_height(y, at, direction)
    return left, right


@inner_kernel
def _half_height(y, at, direction):
    """The same to one side, or to the valley before that."""
    n = len(y)
    half = 0.5 * y[at]
    i = at
    lowest, lowest_at = y[at], at
    while 0 <= i + direction < n:
        following = y[i + direction]
        if following <= half:
            return abs(i - at) + (y[i] - half) / (y[i] - following)
        i += direction
        if following < lowest:
            lowest, lowest_at = following, i
        elif following > y[at]:
            break
    return max(abs(lowest_at - at), 1) + 0.0


@kernel
def widths(y, peaks):
    """Full widths at half maximum in channels, from the steeper side of each peak; shape (n,)."""
    full = np.empty(len(peaks))
    for k in range(len(peaks)):
        left, right = half_heights(y, peaks[k])
        full[k] = max(2.0 * min(left, right), 1.5)
    return full


@kernel
def groups(y, peaks, full):
    """First peak, end peak, first channel and end channel of each group; shape (g, 4).

    y: counts, shape (m,); peaks: ascending channels, shape (n,); full: their widths in channels.
    """
    n = len(peaks)
    found = np.empty((n, 4), np.int64)
    g = 0
    k = 0
    while k < n:
        end = k + 1
        while (
            end < n
            and end - k < MOST_TOGETHER
            and peaks[end] - peaks[end - 1] < TOGETHER * (full[end] + full[end - 1])
        ):
            end += 1
        first = peaks[k] - max(int(REACH * full[k]), LEAST_CHANNELS)
        last = peaks[end - 1] + max(int(REACH * full[end - 1]), LEAST_CHANNELS)
        if k > 0:
            first = max(first, valley(y, peaks[k - 1], peaks[k]))
        if end < n:
            last = min(last, valley(y, peaks[end - 1], peaks[end]))
        found[g, 0], found[g, 1] = k, end
        found[g, 2], found[g, 3] = max(first, 0), min(last, len(y) - 1) + 1
        g += 1
        k = end
    return found[:g]


@inner_kernel
def valley(y, left, right):
    """The lowest channel between two peaks."""
    lowest = left
    for i in range(left + 1, right + 1):
        if y[i] < y[lowest]:
            lowest = i
    return lowest
