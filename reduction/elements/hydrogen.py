"""Electron density from the width of H-alpha, corrected for instrumental broadening.

n_e = 1e17 (w / 1.098 nm)^1.47135 per cm3, w the Stark width (full, at half area) of H-alpha:
Gigosos, Gonzalez and Cardenoso, Spectrochim. Acta B 58, 1489 (2003), as log n_e 16 to 18.
"""

from dataclasses import dataclass

import numpy as np

from ..peaks.profiles import Profiles
from ..peaks.render import render
from ..peaks.voigt import SIGMA_PER_FWHM, Slit, fit_peaks
from ..spectrum.curve import median
from ..spectrum.spectrum import FloatArray
from .offsets import Offsets

H_ALPHA_NM = 656.46  # vacuum, mean of the fine structure
WIDTH_AT_1E17_NM, POWER = 1.098, 1.47135
HALF_WINDOW_NM = 9.0
NEAR_NM = 0.35  # how far its top may be from where it should be
DOPPLER_SIGMA_NM = 0.021  # of hydrogen at 10,000 K
NARROWEST = 0.3  # Stark width in widths of the instrument, below which it says nothing
FORMULA = 0.15  # of ln n_e: the theory's own scatter
SIGNIFICANT = 8.0


@dataclass(frozen=True, slots=True)
class HAlpha:
    """width_nm: Stark width (full); centre and area of the fitted line, counts nm."""

    centre_nm: float
    area: float
    area_error: float
    width_nm: float
    width_error_nm: float

    @property
    def log10_ne(self) -> float:
        """log10 of the electrons per cm3."""
        return 17.0 + POWER * float(np.log10(self.width_nm / WIDTH_AT_1E17_NM))

    @property
    def log10_ne_error(self) -> float:
        relative = POWER * self.width_error_nm / self.width_nm
        return float(np.hypot(relative, FORMULA) / np.log(10))


def h_alpha(
    x: FloatArray, counts: FloatArray, profiles: Profiles, offsets: Offsets
) -> HAlpha | None:
    """Fit H-alpha in a separate window; None if it is not seen or too narrow.

    x: nm, counts: bridged and despiked, both (m,). The background of the whole spectrum would cut
    off its feet, so a straight line under the window is fitted with it.
    """
    at = offsets.place(H_ALPHA_NM)
    window = slice(*np.searchsorted(x, [at - HALF_WINDOW_NM, at + HALF_WINDOW_NM]))
    if window.stop - window.start < 30 or not x[0] + 3 < at < x[-1] - 3:
        return None
    line = _fit(x[window], counts[window], profiles, window, at)
    if line is None:
        return None
    centre, area, area_error, fwhm, error = line
    slit = float(np.interp(at, x, profiles.slit.sigma_nm))
    gauss = float(np.hypot(slit, DOPPLER_SIGMA_NM)) / SIGMA_PER_FWHM
    if abs(centre - at) > NEAR_NM or area < SIGNIFICANT * area_error or fwhm < NARROWEST * gauss:
        return None
    return HAlpha(centre, area, area_error, fwhm, error)


def _fit(x, y, profiles: Profiles, window, at):
    peaks = profiles.peaks
    foreign = (np.abs(peaks.centre_nm - at) > NEAR_NM) & (np.abs(peaks.centre_nm - at) < 12)
    foreign &= peaks.fwhm_nm < 0.6
    others = peaks.where(foreign)
    y = y - render(x, others, 0.05 * profiles.noise[window])
    edge = max(len(x) // 8, 3)
    ends = np.array([median(y[:edge]), median(y[-edge:])])
    y = y - np.interp(x, [x[edge // 2], x[-edge // 2]], ends)
    near = np.flatnonzero(np.abs(x - at) < NEAR_NM)
    if not len(near):
        return None
    width = max(3, round(0.3 / float(median(np.diff(x)))))
    smooth = np.convolve(y, np.full(width, 1 / width), mode="same")
    top = near[np.argmax(smooth[near])]
    if smooth[top] < 2.0 * profiles.noise[window][top]:
        return None
    sigma = np.hypot(profiles.slit.sigma_nm[window], DOPPLER_SIGMA_NM)
    gamma = _half_width(x, smooth, top)
    fitted = fit_peaks(
        x, y, profiles.noise[window], np.array([top]), Slit(sigma, gamma, 0.1, gamma_sure=1e3)
    )
    area, error = float(fitted.area[0]), float(fitted.area_error[0])
    spread = float(np.sqrt(fitted.covariance[0, 3, 3]))
    return float(fitted.centre_nm[0]), area, error, 2 * float(fitted.gamma_nm[0]), 2 * spread


def _half_width(x, smooth, top) -> float:
    half = 0.5 * smooth[top]
    right = next((i for i in range(top, len(x)) if smooth[i] < half), len(x) - 1)
    left = next((i for i in range(top, -1, -1) if smooth[i] < half), 0)
    return 0.5 * float(x[right] - x[left])
