"""Detect an export interpolated from fewer channels: neighbouring channels share their noise.

Second differences over one channel and over two or three have the same size where noise is white.
Interpolated noise is smooth between the detector's own channels, so the first are much smaller.
Lines have the same effect, so only the quietest tenth of the spectrum counts.
"""

import numpy as np

from .curve import quantile
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
    y, one_in = intensity, ONE_IN if n > MANY_BLOCKS else 1
    # At `lag` channels from the chosen ones.
    chosen = {lag: y[lag + 3 :][: n * BLOCK].reshape(n, BLOCK)[::one_in] for lag in range(-3, 4)}
    middle = 2.0 * chosen[0]
    near = _size(chosen, middle, 1)
    least = 1e-12 * (float(np.max(np.abs(middle))) or 1.0)
    return max(
        float(quantile(_size(chosen, middle, lag) / np.maximum(near, least), QUIET))
        for lag in (2, 3)
    )


def _size(chosen, middle, lag):
    size = np.abs(chosen[-lag] - middle + chosen[lag])
    return np.partition(size, BLOCK // 2, axis=1)[:, BLOCK // 2]
