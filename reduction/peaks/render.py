"""Render fitted peaks on the channels, for the explained part and the residual."""

import numpy as np

from ..spectrum.kernel import kernel
from ..spectrum.spectrum import FloatArray
from .faddeeva import faddeeva_row
from .levenberg import ROOT_2, ROOT_2_PI
from .voigt import VoigtPeaks

GONE = 6.0  # sigmas beyond which a Gaussian is nothing


def render(wavelength_nm: FloatArray, peaks: VoigtPeaks, faint: FloatArray) -> FloatArray:
    """Sum of the Voigt profiles in counts at each channel, shape (m,).

    faint: counts at which the foot of a peak is cut off, shape (m,).
    """
    model = np.zeros(len(wavelength_nm))
    _draw(wavelength_nm, peaks.area, peaks.centre_nm, peaks.sigma_nm, peaks.gamma_nm, faint, model)
    return model


@kernel
def _draw(x, area, centre, sigma, gamma, faint, model):
    n = len(x)
    for k in range(len(area)):
        if not area[k] > 0.0:
            continue
        middle = min(np.searchsorted(x, centre[k]), n - 1)
        # A Lorentzian's foot falls below `faint` there; a Gaussian's is gone long before 6 sigma.
        cut, first, end = faint[middle], 0, 0
        for _ in range(2):  # the noise is less beside a line than on it
            foot = np.sqrt(area[k] * gamma[k] / (np.pi * max(cut, 1e-300)))
            reach = max(foot, GONE * sigma[k])
            first = np.searchsorted(x, centre[k] - reach)
            end = np.searchsorted(x, centre[k] + reach)
            cut = min(faint[min(first, n - 1)], faint[max(end - 1, 0)])
        scale, norm = 1.0 / (sigma[k] * ROOT_2), area[k] / (sigma[k] * ROOT_2_PI)
        real, imag = np.empty(end - first), np.empty(end - first)
        faddeeva_row(x[first:end], centre[k], scale, gamma[k] * scale, real, imag)
        for i in range(first, end):
            model[i] += norm * max(real[i - first], 0.0)
