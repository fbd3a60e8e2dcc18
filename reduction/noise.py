"""Estimate the noise of each channel from how neighbouring channels differ.

A second difference of three channels cancels background and slope. The median of its size over a
block of channels does not see the peaks, as long as they take less than half of the block.
"""

import numpy as np

from .spectrum import FloatArray

BLOCK = 400  # channels: some 13 nm of a 22,800-channel spectrum
SIGMA_PER_MEDIAN = 1.4826  # of |x| for normal x (1 / 0.6745)
SECOND_DIFFERENCE_GAIN = np.sqrt(6.0)  # noise of x[i-1] - 2 x[i] + x[i+1] for unit noise
LEAST_PART = 1e-9  # well above the rounding of the steps that follow


def local_noise(intensity: FloatArray, block: int = BLOCK) -> FloatArray:
    """Standard deviation of the noise around each channel, counts, shape (n,).

    intensity: counts, shape (n,), no NaN. The estimates of the blocks are joined by straight
    lines. It is never 0, so that one can divide by it: a spectrum without noise gets LEAST_PART
    of its largest value.
    """
    n = len(intensity)
    floor = LEAST_PART * (float(np.max(np.abs(intensity), initial=0.0)) or 1.0)
    if n < 3:
        return np.full(n, floor)
    size = np.abs(np.diff(intensity, n=2))
    n_blocks = max(len(size) // block, 1)
    width = len(size) // n_blocks
    blocks = size[: n_blocks * width].reshape(n_blocks, width)
    sigma = np.median(blocks, axis=1) * SIGMA_PER_MEDIAN / SECOND_DIFFERENCE_GAIN
    middle = (np.arange(n_blocks) + 0.5) * width
    return np.maximum(np.interp(np.arange(n), middle, sigma), floor)
