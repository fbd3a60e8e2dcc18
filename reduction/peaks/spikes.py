"""Tell spikes that are narrower than a line from lines: single photons of an intensified camera.

Behind an intensifier each photon is a spike of one or two channels, hundreds of counts high, and most
channels have none: the quiet ones between them tell the noise of the read-out alone. A line is at
least as wide as the slit, a weak one as a bright one. So where most of the small peaks are narrow, and
the tall ones wider, the small ones are noise; where tall and small ones are narrow alike, the slit is.
"""

import numpy as np

from ..spectrum.curve import median
from ..spectrum.kernel import kernel
from ..spectrum.spectrum import FloatArray, IntArray
from .windows import half_heights

NARROW, NEVER = 1.8, 1.4  # channels at half height: of a narrow slit; of no grating spectrograph
LEAST, TALLEST = 100, 20  # peaks
WIDER = 1.2  # the tall ones over the small: 0.8 to 1.2 behind a narrow slit, 1.2 to 3.5 of photons


def has_spikes(net: FloatArray, seeds: IntArray) -> bool:
    """Whether most of the small peaks are spikes.

    net: counts above the background, shape (m,); seeds: channels of the peaks.
    """
    if len(seeds) < LEAST:
        return False
    falling = seeds[np.argsort(-net[seeds])]
    tall = median(_full_widths(net, falling[:TALLEST]))
    small = median(_full_widths(net, falling[len(falling) // 2 :]))
    return bool(small < NEVER or (small < NARROW and tall > WIDER * small))


@kernel
def _full_widths(y, peaks):
    """Full widths at half height, channels, shape (n,)."""
    full = np.empty(len(peaks))
    for k in range(len(peaks)):
        left, right = half_heights(y, peaks[k])
        full[k] = left + right
    return full
