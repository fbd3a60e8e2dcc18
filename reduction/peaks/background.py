"""Remove single-channel spikes, then estimate the continuum under the peaks.

SNIP: Ryan et al., Nucl. Instrum. Methods B 34, 396 (1988), with the window shrinking as in
Morhac et al., Nucl. Instrum. Methods A 401, 113 (1997).
"""

import numpy as np

from ..spectrum.bad import bridged, lone
from ..spectrum.curve import even_means, joined, middle_within, usual_pitch_nm
from ..spectrum.kernel import kernel
from ..spectrum.noise import local_noise
from ..spectrum.spectrum import FloatArray, Spectrum
from .snip import clip_peaks

# Wider than any line's foot (H-alpha at 1e17 electrons per cm3 is 1.1 nm wide at half height),
# narrower than the bends of the continuum.
HALF_WINDOW_NM = 3.0
THINNED = 3
SMOOTHED = 9  # channels averaged first, since SNIP follows the lowest noise
QUIET_SIGMA = 3.0


def despike(intensity: FloatArray, noise: FloatArray) -> FloatArray:
    """The counts with isolated spikes (cosmic rays) bridged; shapes (n,)."""
    return bridged(intensity, lone(intensity, noise))


def background(
    spectrum: Spectrum, noise: FloatArray | None = None, half_window_nm: float = HALF_WINDOW_NM
) -> FloatArray:
    """The continuum under the peaks in counts, shape (n,).

    Features narrower than `half_window_nm` are peaks. What SNIP loses by following the lower edge
    of the noise is added back, so that quiet channels scatter around 0 after subtraction.
    """
    if noise is None:
        noise = local_noise(spectrum.intensity)
    return lifted(spectrum, lower_edge(spectrum, half_window_nm), noise)


def lower_edge(spectrum: Spectrum, half_window_nm: float = HALF_WINDOW_NM) -> FloatArray:
    """What SNIP leaves, counts, shape (n,): it follows the lower edge of the noise."""
    n = len(spectrum)
    if n < SMOOTHED:
        return np.full(n, float(np.min(spectrum.intensity)))
    pitch_nm = usual_pitch_nm(spectrum.wavelength_nm)
    # After smoothing one channel in three holds all there is, and SNIP's cost goes with the square.
    even = even_means(spectrum.intensity, SMOOTHED, THINNED // 2, THINNED)
    half_window = max(round(half_window_nm / pitch_nm / THINNED), 2)
    clipped = clip_peaks(even, max(min(half_window, len(even) // 2), 1))
    return joined(clipped, float(THINNED // 2), float(THINNED), n)


def lifted(spectrum: Spectrum, edge: FloatArray, noise: FloatArray) -> FloatArray:
    """The edge moved into the middle of the noise (counts), all of shape (n,)."""
    return edge if len(spectrum) < SMOOTHED else _lifted(spectrum.intensity, edge, noise)


@kernel
def _lifted(y, edge, noise):
    z = np.empty(len(y))
    for i in range(len(y)):
        z[i] = (y[i] - edge[i]) / noise[i]
    middle = middle_within(z, QUIET_SIGMA)
    for i in range(len(y)):
        z[i] = edge[i] + middle * noise[i]
    return z
