"""Find the peaks that stand out of the local noise."""

import numpy as np

from .spectrum import FloatArray, IntArray

SIGNIFICANT = 5.0  # height and prominence, in noise of the smoothed spectrum
# A ripple of less than this part of its height, on the top or flank of a line, is photon noise:
# local noise is measured on the background, where there are few photons.
LEAST_RELATIVE_PROMINENCE = 0.05
WIDEST_CHANNELS = 400  # how far to look for the foot of a peak
KERNEL = np.array([0.25, 0.5, 0.25])
KERNEL_NOISE = float(np.sqrt(np.sum(KERNEL**2)))  # what smoothing leaves of white noise


def find_peaks(
    intensity: FloatArray, noise: FloatArray, significant: float = SIGNIFICANT
) -> IntArray:
    """Channels of the peaks, ascending, shape (k,).

    intensity: counts above the background, shape (n,). noise: standard deviation of each channel
    in counts, shape (n,). A peak is a maximum of the intensity, smoothed over three channels,
    whose height and whose prominence exceed `significant` times the noise that smoothing leaves.
    """
    from scipy import signal  # a third of a second, for those who never look for peaks

    if len(intensity) < len(KERNEL):
        return np.empty(0, dtype=np.int64)
    smooth = np.convolve(np.pad(intensity, 1, mode="edge"), KERNEL, mode="valid")
    least = significant * KERNEL_NOISE * noise
    channels, _ = signal.find_peaks(
        smooth,
        height=least,
        prominence=np.maximum(least, LEAST_RELATIVE_PROMINENCE * smooth),
        wlen=WIDEST_CHANNELS,
    )
    return channels
