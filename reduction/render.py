"""Draw fitted peaks back onto the channels: what is explained, and what is left over."""

import numpy as np

from .faddeeva import faddeeva
from .kernel import float_kernel
from .levenberg import ROOT_2, ROOT_2_PI
from .spectrum import FloatArray
from .voigt import VoigtPeaks

FAINT = 0.02  # of the noise: below this a foot is not drawn any further


def render(wavelength_nm: FloatArray, peaks: VoigtPeaks, faint: FloatArray) -> FloatArray:
    """Sum of the Voigt profiles in counts at each channel, shape (m,).

    faint: counts below which the foot of a peak is cut off, shape (m,).
    """
    model = np.zeros(len(wavelength_nm))
    _draw(wavelength_nm, peaks.area, peaks.centre_nm, peaks.sigma_nm, peaks.gamma_nm, faint, model)
    return model


@float_kernel
def _draw(x, area, centre, sigma, gamma, faint, model):
    for k in range(len(area)):
        if not area[k] > 0.0:
            continue
        scale, norm = 1.0 / (sigma[k] * ROOT_2), area[k] / (sigma[k] * ROOT_2_PI)
        middle = np.searchsorted(x, centre[k])
        for direction in (-1, 1):
            i = middle if direction > 0 else middle - 1
            while 0 <= i < len(x):
                z = complex((x[i] - centre[k]) * scale, gamma[k] * scale)
                value = norm * faddeeva(z).real
                if value < faint[i]:
                    break
                model[i] += value
                i += direction
