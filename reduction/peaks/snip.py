"""Clip the peaks of a curve: the loop of SNIP."""

import numpy as np

from ..spectrum.kernel import kernel
from ..spectrum.spectrum import FloatArray


def clip_peaks(intensity: FloatArray, half_window: int) -> FloatArray:
    """The curve under the peaks, counts, shape (n,); peaks narrower than half_window channels are removed.

    The counts are compressed by a double logarithm of a square root first, so that one strong
    line does not lift its surroundings (Ryan 1988).
    """
    lowest = intensity.min()
    compressed = np.log(np.log(np.sqrt(intensity - lowest + 1.0) + 1.0) + 1.0)
    clipped = _clip(compressed, half_window)
    return (np.exp(np.exp(clipped) - 1.0) - 1.0) ** 2 - 1.0 + lowest


@kernel
def _clip(values, half_window):
    n = len(values)
    now = values.copy()  # the ends that a reach does not touch are equal in both
    then = values.copy()
    for reach in range(half_window, 0, -1):
        # Parts that are all counted from 0: several channels at once, which takes a fifth of the time.
        left, middle, right = now[: n - 2 * reach], now[reach : n - reach], now[2 * reach :]
        lowered = then[reach : n - reach]
        for i in range(n - 2 * reach):
            mean = 0.5 * (left[i] + right[i])
            lowered[i] = mean if mean < middle[i] else middle[i]
        now, then = then, now
    return now
