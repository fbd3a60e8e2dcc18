"""Detect an export interpolated from fewer channels: neighbouring channels share their noise.

Second differences over one channel and over two or three have the same size where noise is white.
Interpolated noise is smooth between the detector's own channels, so the first are much smaller.
Lines have the same effect, so only the quietest tenth of the spectrum counts.
"""

import numpy as np

from .curve import put_in_place, quantile
from .kernel import kernel
from .spectrum import FloatArray

BLOCK = 64  # channels
ONE_IN = 4  # blocks that are examined, in long spectra
MANY_BLOCKS = 160
LEAST_BLOCKS = 12
QUIET = 0.1  # quantile of the blocks
SHARED, SETTLED = 1.5, 1.2  # ratio of the differences: certainly shared; no longer shared
WHITE = 0.8  # what the ratio usually is where noise is white
MOST_CHANNELS = 8


def resampled(intensity: FloatArray) -> int:
    """How many neighbouring channels share their noise; 1 if each has its own.

    intensity: counts, shape (n,), no NaN. Means of that many neighbours have nearly white noise.
    """
    if sharing(intensity) < SHARED:
        return 1
    for channels in range(2, MOST_CHANNELS):
        n = len(intensity) // channels * channels
        if sharing(intensity[:n].reshape(-1, channels).mean(axis=1)) < SETTLED:
            return channels
    return MOST_CHANNELS


def sharing(intensity: FloatArray) -> float:
    """Size of differences over two or three channels, over that of one; about 0.8 if noise is white."""
    n = (len(intensity) - 6) // BLOCK
    if n < LEAST_BLOCKS:
        return 0.0
    return _ratio(intensity, n, ONE_IN if n > MANY_BLOCKS else 1)


@kernel
def _ratio(y, n, one_in):
    """The larger ratio of over two and over three channels, in the quietest of every `one_in` of n blocks."""
    blocks = (n + one_in - 1) // one_in
    ratio, size, most = np.empty((2, blocks)), np.empty(BLOCK), 0.0
    for b in range(blocks):
        for i in range(3 + b * one_in * BLOCK, 3 + b * one_in * BLOCK + BLOCK):
            most = max(most, 2.0 * abs(y[i]))
    least = 1e-12 * (most if most > 0.0 else 1.0)
    for b in range(blocks):
        begin, near = 3 + b * one_in * BLOCK, least
        for lag in range(1, 4):
            for i in range(BLOCK):
                at = begin + i
                size[i] = abs(y[at - lag] - 2.0 * y[at] + y[at + lag])
            put_in_place(size, BLOCK // 2)
            if lag == 1:
                near = max(size[BLOCK // 2], least)
            else:
                ratio[lag - 2, b] = size[BLOCK // 2] / near
    return max(quantile(ratio[0], QUIET), quantile(ratio[1], QUIET))
