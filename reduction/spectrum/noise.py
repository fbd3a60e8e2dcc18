"""Estimate the noise of each channel from how neighbouring channels differ.

A second difference of three channels cancels background and slope. A low quantile of its size over
a block of channels ignores the peaks, as long as they leave a third of the block free. For more
crowded lines, `steadied` judges a block by all blocks of equal brightness.

An export that was cut at zero looks noiseless where nothing else is left, and one that was rounded
where it was rounded to the same number; neither is believed.
"""

from dataclasses import dataclass

import numpy as np

from .curve import joined, median, quantile
from .kernel import kernel
from .same_axis import of_axis
from .spectrum import BoolArray, FloatArray

BLOCK = 400  # channels: some 13 nm of a 22,800-channel spectrum
QUANTILE = 0.25  # of the differences: peaks may take more than half of a block
SIGMA_PER_QUANTILE = 1.0 / 0.31864  # of |x| for normal x
SECOND_DIFFERENCE_GAIN = np.sqrt(6.0)  # noise of x[i-1] - 2 x[i] + x[i+1] for unit noise
LEAST_BLOCKS = 12  # fewer have no law
N_BINS = 5
QUIET_BLOCKS = 0.35  # quantile: crowded blocks show too much noise, none too little
MOST_OF_LAW = 1.25
LEAST_PART = 1e-9  # well above the rounding of the steps that follow
CUT, MOST_CUT = 0.002, 0.9  # part of the channels at the lowest value: cut off there; nothing left
LEAST_LEFT = 0.15  # of a block's differences, to be believed
CUT_SHRINKS = 1.25  # noise over what is seen of it where its lower half is cut off
ROUNDED, ROUNDING = 0.02, 0.41  # part of equal neighbours; noise of rounding, in its own steps


def local_noise(intensity: FloatArray, block: int = BLOCK, lag: int = 1) -> FloatArray:
    """Standard deviation of the noise around each channel, counts, shape (n,).

    intensity: counts, shape (n,), no NaN. lag: how many channels apart those are that are
    compared. The estimates of the blocks are joined by straight lines. It is never 0, so that it
    can be a divisor: a spectrum without noise gets LEAST_PART of its largest value.
    """
    n = len(intensity)
    floor = LEAST_PART * (float(np.max(np.abs(intensity), initial=0.0)) or 1.0)
    if n <= 2 * lag:
        return np.full(n, floor)
    size = np.abs(
        np.diff(intensity, n=2) if lag == 1
        else intensity[: -2 * lag] - 2.0 * intensity[lag:-lag] + intensity[2 * lag :]
    )  # fmt: skip
    n_blocks = max(len(size) // block, 1)
    width = len(size) // n_blocks
    blocks = size[: n_blocks * width].reshape(n_blocks, width)
    cut = cut_off(intensity)
    if cut.any():
        spoiled = cut[: -2 * lag] | cut[lag:-lag] | cut[2 * lag :]
        sigma = _beside_cut(blocks, spoiled[: n_blocks * width])
    else:
        place = int(QUANTILE * width)
        low = np.partition(blocks, place, axis=1)[:, place]
        sigma = low * SIGMA_PER_QUANTILE / SECOND_DIFFERENCE_GAIN
    floor = max(floor, ROUNDING * _rounded_to(size, cut[lag:-lag]))
    return joined(np.maximum(sigma, floor), 0.5 * width, float(width), n)


noise_once = of_axis(local_noise)
"""The same for steps that ask for it one after the other, of the same counts; not to be changed."""


def noise_apart(intensity: FloatArray, lag: int) -> FloatArray:
    """The noise, counts, (n,), where channels nearer than `lag` share theirs; not to be changed.

    Where lines are crowded they count for noise over so many channels. How much more noise there
    is than neighbours tell changes little along the axis, so it is bounded by its middle.
    """
    near = noise_once(intensity)
    if lag == 1:
        return near
    more = local_noise(intensity, lag=lag) / near
    return near * np.minimum(more, MOST_OF_LAW * float(median(more)))


def cut_off(intensity: FloatArray) -> BoolArray:
    """Channels whose counts were below the lowest value that the export knows; shape (n,).

    That many channels of exactly the lowest value, and more of it than of the next values together,
    are no chance.
    """
    at = intensity == np.min(intensity, initial=np.inf)
    n = np.count_nonzero(at)
    if n < max(CUT * len(intensity), 8) or n > MOST_CUT * len(intensity) or not _cut(intensity):
        at.fill(False)
    return at


@of_axis
def _cut(intensity: FloatArray) -> bool:
    """Whether the lowest value is more frequent than the next ones together."""
    lowest = np.min(intensity)
    beyond = intensity[intensity > lowest] - lowest
    width = float(quantile(beyond, 0.02))  # the lowest fiftieth of the others lies within
    return bool(len(intensity) - len(beyond) > np.count_nonzero(beyond <= 0.2 * width))


def _beside_cut(blocks: FloatArray, spoiled: BoolArray) -> FloatArray:
    """Noise of each block, counts, from differences without a cut channel."""
    spoiled = spoiled.reshape(blocks.shape)
    sigma = np.full(len(blocks), np.nan)
    for k in range(len(blocks)):
        left = blocks[k][~spoiled[k]]
        if len(left) >= LEAST_LEFT * blocks.shape[1]:
            shrunk = 1.0 + (CUT_SHRINKS - 1.0) * float(np.mean(spoiled[k]))
            sigma[k] = (
                shrunk * quantile(left, QUANTILE) * SIGMA_PER_QUANTILE / SECOND_DIFFERENCE_GAIN
            )
    told = np.flatnonzero(np.isfinite(sigma))
    if not len(told):
        left = blocks[~spoiled]
        some = quantile(left, QUANTILE) if len(left) else 0.0
        return np.full(len(blocks), some * SIGMA_PER_QUANTILE / SECOND_DIFFERENCE_GAIN)
    return np.interp(np.arange(len(blocks)), told, sigma[told])


def _rounded_to(size: FloatArray, cut: BoolArray) -> float:
    """The step to which counts were rounded; 0 where neighbours are seldom equal."""
    equal = size == 0.0
    if cut.any():
        equal &= ~cut
    if np.count_nonzero(equal) < ROUNDED * len(size):
        return 0.0
    moved = size[size > 0.0]
    return float(quantile(moved, 0.01)) if len(moved) else 0.0


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
    under = above_0(under)
    light = under[middle]
    read, gain, told = _law(sigma[middle], light, np.argsort(light, kind="stable"))
    return Noise(_bounded(sigma, under, read, gain), gain if told else None)


def above_0(under: FloatArray) -> FloatArray:
    """The continuum, counts, shape (n,), moved up by as much as its lowest value is below 0.

    An export from which more than its dark counts was taken off lies below 0 throughout.
    """
    return under - min(float(np.min(under, initial=0.0)), 0.0)


@kernel
def _law(sigma, light, order):
    """read^2 and gain of the quieter blocks, and whether the light varies enough to trust it.

    order: of the blocks by their light.
    """
    n = len(order)
    n_bins = min(N_BINS, n // 4)
    x, v = np.zeros(n_bins), np.empty(n_bins)
    begin, mean_x, mean_v, least_v = 0, 0.0, 0.0, np.inf
    for k in range(n_bins):
        end = begin + n // n_bins + (1 if k < n % n_bins else 0)
        variance = np.empty(end - begin)
        for i in range(begin, end):
            variance[i - begin] = sigma[order[i]] ** 2
            x[k] += light[order[i]] / (end - begin)
        v[k] = quantile(variance, QUIET_BLOCKS)
        mean_x, mean_v, least_v = mean_x + x[k] / n_bins, mean_v + v[k] / n_bins, min(least_v, v[k])
        begin = end
    along, across = 0.0, 0.0
    for k in range(n_bins):
        along += (x[k] - mean_x) * v[k]
        across += (x[k] - mean_x) ** 2
    gain = max(along / max(across, 1e-30), 0.0)
    read = max(mean_v - gain * mean_x, 0.05 * least_v)
    return read, gain, gain * (x[n_bins - 1] - x[0]) > read


@kernel
def _bounded(sigma, under, read, gain):
    """The noise, no larger than what the law allows over the continuum, counts, (n,)."""
    out = np.empty(len(sigma))
    for i in range(len(sigma)):
        law = np.sqrt(max(read + gain * under[i], 1e-30))
        out[i] = max(min(sigma[i], MOST_OF_LAW * law), LEAST_PART)
    return out
