"""Fit a Voigt profile to every peak: area, centre, widths, and how sure each of them is.

The profile is the convolution of a Gaussian (instrument, Doppler; standard deviation sigma) with a
Lorentzian (Stark; half width at half maximum gamma), normalised to the area:
V(x) = area * Re w(z) / (sigma sqrt(2 pi)), z = (x - centre + i gamma) / (sigma sqrt(2)).
"""

from dataclasses import dataclass

import numpy as np

from .kernel import float_kernel
from .levenberg import PER_LINE, PER_PEAK, evaluate, factorise, fit, solve
from .spectrum import BoolArray, FloatArray, IntArray
from .windows import groups, widths

SIGMA_PER_FWHM = float(1.0 / np.sqrt(8.0 * np.log(2.0)))
# First guess: two thirds of the width Gaussian, one third Lorentzian, which is near for both.
GAUSSIAN_PART, LORENTZIAN_PART = 0.75, 0.3
VOIGT_AREA_PER_BOX = 1.2  # area / (height * fwhm): 1.06 for a Gaussian, 1.57 for a Lorentzian
NARROWEST = 0.2  # sigma, in channels: less cannot be told from a single channel
# What subtraction may leave under a group, in noise; what is more is the feet of the peaks.
LINE_NOISE = 1.0
WIDEST = 4.0  # sigma and gamma, in widths seen at half height


@dataclass(frozen=True, slots=True, eq=False)
class VoigtPeaks:
    """Fitted peaks, ascending in channel; arrays of shape (n,) unless said otherwise.

    area: counts nm. centre_nm, sigma_nm, gamma_nm: nm. covariance: (n, 4, 4) in the order area,
    centre, sigma, gamma, scaled by chi2 where that exceeds 1. chi2: per degree of freedom.
    settled: False where the fit ran out of steps.
    """

    area: FloatArray
    centre_nm: FloatArray
    sigma_nm: FloatArray
    gamma_nm: FloatArray
    covariance: FloatArray
    chi2: FloatArray
    settled: BoolArray

    def __len__(self) -> int:
        return len(self.area)

    @property
    def area_error(self) -> FloatArray:
        """Standard error of the areas, counts nm."""
        return np.sqrt(self.covariance[:, 0, 0])

    @property
    def fwhm_nm(self) -> FloatArray:
        """Full width at half maximum, to 0.02 % (Olivero & Longbothum, JQSRT 17, 233 (1977))."""
        gaussian, lorentzian = self.sigma_nm / SIGMA_PER_FWHM, 2.0 * self.gamma_nm
        return 0.5346 * lorentzian + np.sqrt(0.2166 * lorentzian**2 + gaussian**2)


def voigt(
    wavelength_nm: FloatArray, area: float, centre_nm: float, sigma_nm: float, gamma_nm: float
) -> FloatArray:
    """One Voigt profile in counts at wavelengths in nm, shape (n,). sigma must exceed 0."""
    p = np.array([area, 0.0, sigma_nm, gamma_nm, 0.0, 0.0])
    x = np.asarray(wavelength_nm, dtype=np.float64) - centre_nm
    model = np.empty(len(x))
    evaluate(p, x, model, np.empty((len(p), len(x))))
    return model


def fit_peaks(
    wavelength_nm: FloatArray, intensity: FloatArray, noise: FloatArray, peaks: IntArray
) -> VoigtPeaks:
    """Fit the peaks at the channels `peaks` (ascending), neighbours that overlap together.

    wavelength_nm: shape (m,), ascending. intensity: counts above the background, shape (m,), no
    NaN. noise: standard deviation of each channel, counts, above 0. Raises ValueError on NaN.
    """
    if not np.isfinite(intensity).all():
        raise ValueError("intensities must be numbers; bridge bad channels first")
    y = np.ascontiguousarray(intensity, dtype=np.float64)
    channels = np.ascontiguousarray(peaks, dtype=np.int64)
    fitted, covariance, chi2, settled = _fit_all(
        np.ascontiguousarray(wavelength_nm, dtype=np.float64),
        y,
        1.0 / np.asarray(noise, dtype=np.float64) ** 2,
        channels,
        widths(y, channels),
    )
    area, centre_nm, sigma_nm, gamma_nm = fitted.T.copy()
    return VoigtPeaks(area, centre_nm, sigma_nm, gamma_nm, covariance, chi2, settled)


@float_kernel
def _guess(x, y, peaks, full, pitch):
    """Parameters and their bounds for one group; x in nm from the middle of the window."""
    n = PER_PEAK * len(peaks) + PER_LINE
    p, lowest, highest = np.zeros(n), np.full(n, -np.inf), np.full(n, np.inf)
    for k in range(len(peaks)):
        at = PER_PEAK * k
        seen = full[k] * pitch
        height = max(y[peaks[k]], 0.0)
        p[at] = VOIGT_AREA_PER_BOX * height * seen
        p[at + 1] = x[peaks[k]]
        p[at + 2] = GAUSSIAN_PART * SIGMA_PER_FWHM * seen
        p[at + 3] = LORENTZIAN_PART * 0.5 * seen
        lowest[at] = 0.0
        lowest[at + 1], highest[at + 1] = p[at + 1] - seen, p[at + 1] + seen
        lowest[at + 2], highest[at + 2] = NARROWEST * pitch, WIDEST * seen
        lowest[at + 3], highest[at + 3] = 0.0, WIDEST * seen
    return p, lowest, highest


@float_kernel
def _fit_all(wavelength_nm, y, weight, peaks, full):
    n = len(peaks)
    fitted, covariance = np.zeros((n, PER_PEAK)), np.zeros((n, PER_PEAK, PER_PEAK))
    chi2, settled = np.zeros(n), np.zeros(n, np.bool_)
    for first_peak, end_peak, first, end in groups(y, peaks, full):
        middle = wavelength_nm[(first + end) // 2]
        x = wavelength_nm[first:end] - middle
        pitch = (x[-1] - x[0]) / max(len(x) - 1, 1)
        p, lowest, highest = _guess(
            x, y[first:end], peaks[first_peak:end_peak] - first, full[first_peak:end_peak], pitch
        )
        pull = np.zeros(len(p))
        pull[-2] = np.mean(weight[first:end]) / LINE_NOISE**2
        pull[-1] = pull[-2] * (0.5 * (x[-1] - x[0])) ** 2
        total, hessian, done = fit(p, x, y[first:end], weight[first:end], pull, lowest, highest)
        free = max(len(x) - len(p), 1)
        reduced = total / free
        lower = np.zeros_like(hessian)
        known = factorise(hessian, lower)
        unit, column = np.zeros(len(p)), np.zeros(len(p))
        for k in range(end_peak - first_peak):
            at, peak = PER_PEAK * k, first_peak + k
            fitted[peak] = p[at : at + PER_PEAK]
            fitted[peak, 1] += middle
            chi2[peak], settled[peak] = reduced, done
            for a in range(PER_PEAK):
                unit[:] = 0.0
                unit[at + a] = 1.0
                if known:
                    solve(lower, unit, column)
                    covariance[peak, a] = column[at : at + PER_PEAK] * max(reduced, 1.0)
                else:
                    covariance[peak, a] = np.nan
    return fitted, covariance, chi2, settled
