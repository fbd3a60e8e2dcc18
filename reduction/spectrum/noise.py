"""Estimate the noise of each channel from how neighbouring channels differ.

A second difference of three channels cancels background and slope. A low quantile of its size over
a block of channels ignores the peaks, as long as they leave a third of the block free. For more
crowded lines, `steadied` judges a block by all blocks of equal brightness.
"""

from dataclasses import dataclass

import numpy as np

from .curve import joined, quantile
from .spectrum import FloatArray

BLOCK = 400  # channels: some 13 nm of a 22,800-channel spectrum
QUANTILE = 0.25  # of the differences: peaks may take more than half of a block
SIGMA_PER_QUANTILE = 1.0 / 0.31864  # of |x| for normal x
SECOND_DIFFERENCE_GAIN = np.sqrt(6.0)  # noise of x[i-1] - 2 x[i] + x[i+1] for unit noise
LEAST_BLOCKS = 12  # fewer have no law
N_BINS = 5
QUIET_BLOCKS = 0.35  # quantile: crowded blocks show too much noise, none too little
MOST_OF_LAW = 1.25
LEAST_PART = 1e-9  # well above the rounding of the steps that follow


def local_noise(intensity: FloatArray, block: int = BLOCK) -> FloatArray:
    """Standard deviation of the noise around each channel, counts, shape (n,).

    intensity: counts, shape (n,), no NaN. The estimates of the blocks are joined by straight
    lines. It is never 0, so that it can be a divisor: a spectrum without noise gets LEAST_PART
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
    place = int(QUANTILE * width)
    low = np.partition(blocks, place, axis=1)[:, place]
    sigma = low * SIGMA_PER_QUANTILE / SECOND_DIFFERENCE_GAIN
    return joined(np.maximum(sigma, floor), 0.5 * width, float(width), n)


@dataclass(frozen=True, slots=True, eq=False)
class Noise:
    """sigma: standard deviation of each channel without line light, counts, shape (n,).

    gain: variance (counts^2) per count of light, from the continuum; None if the continuum is too
    even.
    """

    sigma: FloatArray
    gain: float | None


def steadied(sigma: FloatArray, under: FloatArray, block: int = BLOCK) -> Noise:
    """The noise, bounded by the law variance = read^2 + gain * continuum that all blocks follow.

    sigma: from `local_noise`; under: continuum in counts; both shape (n,).
    """
    middle = np.arange(block // 2, len(sigma), block)
    if len(middle) < LEAST_BLOCKS:
        return Noise(sigma, None)
    variance, light = sigma[middle] ** 2, np.maximum(under[middle], 0.0)
    read, gain, told = _law(variance, light)
    law = np.sqrt(np.maximum(read + gain * np.maximum(under, 0.0), 1e-30))
    bounded = np.minimum(sigma, MOST_OF_LAW * law)
    return Noise(np.maximum(bounded, LEAST_PART), gain if told else None)


def _law(variance, light):
    """read^2 and gain of the quieter blocks, and whether the light varies enough to trust it."""
    order = np.argsort(light)
    bins = np.array_split(order, min(N_BINS, len(order) // 4))
    v = np.array([quantile(variance[part], QUIET_BLOCKS) for part in bins])
    x = np.array([np.mean(light[part]) for part in bins])
    spread = x - x.mean()
    gain = max(float(spread @ v) / max(float(spread @ spread), 1e-30), 0.0)
    read = max(float(np.mean(v) - gain * x.mean()), 0.05 * float(v.min()))
    return read, gain, gain * float(np.ptp(x)) > read
