"""Tell spikes that are narrower than a line from lines: single photons of an intensified camera.

Behind an intensifier each photon is a spike of one or two channels, hundreds of counts high, and most
channels have none: the quiet ones between them tell the noise of the read-out alone. A line is at
least as wide as the slit. So where many peaks are narrower than any slit makes them, they are noise.
"""

import numpy as np

from ..spectrum.kernel import float_kernel
from ..spectrum.spectrum import FloatArray, IntArray
from .windows import half_height

NARROW = 1.8  # channels at half height: no grating spectrograph has lines so narrow
LEAST, PART = 100, 0.2  # peaks; of them narrow: on other spectra 0.05 at most


def has_spikes(net: FloatArray, seeds: IntArray) -> bool:
    """Whether many of the peaks are spikes.

    net: counts above the background, shape (m,); seeds: channels of the peaks.
    """
    return len(seeds) >= LEAST and bool(np.mean(_full_widths(net, seeds) < NARROW) > PART)


@float_kernel
def _full_widths(y, peaks):
    """Full widths at half height, channels, shape (n,)."""
    full = np.empty(len(peaks))
    for k in range(len(peaks)):
        full[k] = half_height(y, peaks[k], -1) + half_height(y, peaks[k], 1)
    return full
