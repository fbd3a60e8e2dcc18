"""Find the peaks that exceed the local noise."""

import numpy as np

from ..spectrum.curve import softened
from ..spectrum.kernel import inner_kernel, kernel
from ..spectrum.spectrum import FloatArray, IntArray

SIGNIFICANT = 5.0  # height and prominence, in noise of the smoothed spectrum
# A ripple of less than this part of its height, on the top or flank of a line, is photon noise:
# local noise is measured on the background, where there are few photons.
LEAST_RELATIVE_PROMINENCE = 0.05
WIDEST_CHANNELS = 400  # how far to look for the foot of a peak
SOFTENED_NOISE = float(np.sqrt(0.25**2 + 0.5**2 + 0.25**2))  # what smoothing leaves of white noise


def find_peaks(
    intensity: FloatArray, noise: FloatArray, significant: float = SIGNIFICANT
) -> IntArray:
    """Channels of the peaks, ascending, shape (k,).

    intensity: counts above the background, shape (n,). noise: standard deviation of each channel
    in counts, shape (n,). A peak is a maximum of the intensity, smoothed over three channels,
    whose height and whose prominence exceed `significant` times the noise that smoothing leaves.
    """
    return standing_out(softened(intensity), noise, significant)[0]


def standing_out(
    soft: FloatArray, noise: FloatArray, significant: float = SIGNIFICANT
) -> tuple[IntArray, FloatArray]:
    """The same channels, and the height or prominence of each, the less of both, in noise.

    soft: the intensity as `softened` smooths it.
    """
    if len(soft) < 3:
        return np.empty(0, dtype=np.int64), np.empty(0)
    channels, counts = _stand_out(soft, noise, significant * SOFTENED_NOISE)
    return channels, counts / SOFTENED_NOISE


@kernel
def _stand_out(y, noise, significant):
    n = len(y)
    found, clear = np.empty(n // 2 + 1, np.int64), np.empty(n // 2 + 1)
    k, end = 0, 0
    for i in range(1, n - 1):
        if y[i] < significant * noise[i] or not y[i - 1] < y[i] or i <= end:
            continue
        end = i  # of a plateau
        while end < n - 1 and y[end + 1] == y[i]:
            end += 1
        if end < n - 1 and y[end + 1] < y[i]:
            top = (i + end) // 2
            height = min(y[top], _prominence(y, top))
            if height >= significant * noise[top] and height >= LEAST_RELATIVE_PROMINENCE * y[top]:
                found[k], clear[k] = top, height / noise[top]
                k += 1
    return found[:k].copy(), clear[:k].copy()


def clear_of(soft: FloatArray, noise: FloatArray, channels: IntArray) -> FloatArray:
    """Height or prominence of peaks at channels, the less of both, in noise; 0 where none is; (k,)."""
    return _clear_of(soft, noise, channels) / SOFTENED_NOISE


@kernel
def _clear_of(y, noise, channels):
    clear = np.zeros(len(channels))
    for k in range(len(channels)):
        top = channels[k]
        begin = end = top
        while begin > 0 and y[begin - 1] == y[top]:
            begin -= 1
        while end < len(y) - 1 and y[end + 1] == y[top]:
            end += 1
        within = begin > 0 and end < len(y) - 1 and top == (begin + end) // 2
        if not within or not (y[begin - 1] < y[top] and y[end + 1] < y[top]):
            continue
        height = min(y[top], _prominence(y, top))
        if height >= SOFTENED_NOISE * noise[top] and height >= LEAST_RELATIVE_PROMINENCE * y[top]:
            clear[k] = height / noise[top]
    return clear


@inner_kernel
def _prominence(y, top):
    """Prominence: the least descent from a peak on the way to higher ground."""
    reach = WIDEST_CHANNELS // 2
    left = right = y[top]
    i = top
    while i >= max(top - reach, 0) and y[i] <= y[top]:
        left = min(left, y[i])
        i -= 1
    i = top
    while i <= min(top + reach, len(y) - 1) and y[i] <= y[top]:
        right = min(right, y[i])
        i += 1
    return y[top] - max(left, right)
