"""Fit a Voigt profile to every peak: area, centre, widths, and their uncertainties.

The profile is the convolution of a Gaussian (instrument, Doppler; standard deviation sigma) with a
Lorentzian (Stark; half width at half maximum gamma), normalised to the area:
V(x) = area * Re w(z) / (sigma sqrt(2 pi)), z = (x - centre + i gamma) / (sigma sqrt(2)).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..spectrum.kernel import kernel, part_kernel
from ..spectrum.spectrum import BoolArray, FloatArray, IntArray
from .faddeeva import faddeeva
from .levenberg import PER_LINE, PER_PEAK, ROOT_2, ROOT_2_PI, factorise, fit, solve
from .windows import groups, widths

SIGMA_PER_FWHM = float(1.0 / np.sqrt(8.0 * np.log(2.0)))
# First guess: two thirds of the width Gaussian, one third Lorentzian, which is near for both.
GAUSSIAN_PART, LORENTZIAN_PART = 0.75, 0.3
VOIGT_AREA_PER_BOX = 1.2  # area / (height * fwhm): 1.06 for a Gaussian, 1.57 for a Lorentzian
NARROWEST = 0.2  # sigma, in channels: less cannot be told from a single channel
# What subtraction may leave under a group, in noise; what is more is the feet of the peaks.
LINE_NOISE = 1.0
WIDEST = 4.0  # sigma and gamma, in widths seen at half height
GAMMA_SURE = 0.4  # how far gamma may be from what is usual, in sigmas of the slit


@dataclass(frozen=True, eq=False)
class VoigtPeaks:
    """Fitted peaks, ascending in channel; arrays of shape (n,) unless stated otherwise.

    area: counts nm. centre_nm, sigma_nm, gamma_nm: nm. covariance: (n, 4, 4) in the order area,
    centre, sigma, gamma, scaled by chi2 where that exceeds 1. chi2: per degree of freedom.
    settled: False if the fit ran out of steps.
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

    def where(self, chosen: np.ndarray) -> "VoigtPeaks":
        """The peaks that a mask or indices choose."""
        return VoigtPeaks(
            self.area[chosen], self.centre_nm[chosen], self.sigma_nm[chosen], self.gamma_nm[chosen],
            self.covariance[chosen], self.chi2[chosen], self.settled[chosen],
        )  # fmt: skip

    @cached_property
    def area_error(self) -> FloatArray:
        """Standard error of the areas, counts nm."""
        return np.sqrt(self.covariance[:, 0, 0])

    @cached_property
    def fwhm_nm(self) -> FloatArray:
        """Full width at half maximum, to 0.02 % (Olivero & Longbothum, JQSRT 17, 233 (1977))."""
        gaussian, lorentzian = self.sigma_nm / SIGMA_PER_FWHM, 2.0 * self.gamma_nm
        return 0.5346 * lorentzian + np.sqrt(0.2166 * lorentzian**2 + gaussian**2)


def voigt(
    wavelength_nm: FloatArray, area: float, centre_nm: float, sigma_nm: float, gamma_nm: float
) -> FloatArray:
    """One Voigt profile in counts at wavelengths in nm, shape (n,). sigma must exceed 0."""
    away = np.asarray(wavelength_nm, dtype=np.float64) - centre_nm
    return _profile((away + 1j * gamma_nm) / (sigma_nm * ROOT_2)) * area / (sigma_nm * ROOT_2_PI)


@kernel
def _profile(z):
    real = np.empty(len(z))
    for i in range(len(z)):
        real[i] = faddeeva(z[i]).real
    return real


class Slit(NamedTuple):
    """Prior knowledge of a line's shape.

    sigma_nm: Gaussian width of the instrument at each channel, shape (m,). gamma_nm: Lorentzian
    half width that lines of this plasma usually have. sure: standard deviation of sigma, as a
    part of it; gamma_sure: of gamma, in sigmas of the slit.
    """

    sigma_nm: FloatArray
    gamma_nm: float
    sure: float = 0.06
    gamma_sure: float = GAMMA_SURE


class _Known(NamedTuple):
    """Channels that were fitted, ascending, and their peaks, (k,); what `VoigtPeaks` has of them."""

    channels: IntArray
    area: FloatArray
    centre_nm: FloatArray
    sigma_nm: FloatArray
    gamma_nm: FloatArray
    covariance: FloatArray
    chi2: FloatArray
    settled: BoolArray


def _known(before: tuple[IntArray, VoigtPeaks] | None) -> _Known:
    if before is None:
        return NOTHING_KNOWN
    channels, p = before
    return _Known(
        channels, p.area, p.centre_nm, p.sigma_nm, p.gamma_nm, p.covariance, p.chi2, p.settled
    )


NONE = np.empty(0)
NOTHING_KNOWN = _Known(
    np.empty(0, np.int64), NONE, NONE, NONE, NONE, np.empty((0, PER_PEAK, PER_PEAK)), NONE,
    np.empty(0, np.bool_),
)  # fmt: skip


def fit_peaks(
    wavelength_nm: FloatArray,
    intensity: FloatArray,
    noise: FloatArray,
    peaks: IntArray,
    slit: Slit | None = None,
    before: tuple[IntArray, VoigtPeaks] | None = None,
    start: tuple[IntArray, VoigtPeaks] | None = None,
) -> VoigtPeaks:
    """Fit the peaks at the channels `peaks` (ascending), neighbours that overlap together.

    wavelength_nm: shape (m,), ascending. intensity: counts above the background, shape (m,), no
    NaN. noise: standard deviation of each channel, counts, above 0. slit: pulls the widths towards
    what is known of them, which steadies weak and crowded peaks; without it the widths are free.
    before: channels that were fitted already, and their peaks: groups without a new member stay.
    start: channels that were fitted to other noise or without the slit: where to begin from.
    Raises ValueError on NaN.
    """
    if not np.isfinite(intensity.sum()):
        raise ValueError("intensities must be numbers; bridge bad channels first")
    x = np.ascontiguousarray(wavelength_nm, dtype=np.float64)
    y = np.ascontiguousarray(intensity, dtype=np.float64)
    channels = np.ascontiguousarray(peaks, dtype=np.int64)
    slit = slit or Slit(np.zeros(len(x)), 0.0)
    fitted, covariance, chi2, settled = _fit_all(
        x, y, np.ascontiguousarray(noise, dtype=np.float64), channels, slit, _known(before),
        _known(start),
    )  # fmt: skip
    area, centre_nm, sigma_nm, gamma_nm = fitted
    return VoigtPeaks(area, centre_nm, sigma_nm, gamma_nm, covariance, chi2, settled)


def among(some: IntArray, channels: IntArray) -> BoolArray:
    """Which of some channels are among others, ascending, as those are; shape of `some`."""
    if not len(channels):
        return np.zeros(len(some), dtype=np.bool_)
    return channels[np.minimum(np.searchsorted(channels, some), len(channels) - 1)] == some


@part_kernel
def _seen_widths(x, y, peaks, slit):
    """Full widths of the peaks in channels, no less than the slit allows; shape (n,)."""
    full, last = widths(y, peaks), len(x) - 1
    for k in range(len(peaks)):
        before, after = max(peaks[k] - 1, 0), min(peaks[k] + 1, last)
        if slit.sigma_nm[peaks[k]] > 0.0 and after > before:
            pitch = (x[after] - x[before]) / (after - before)
            least = slit.sigma_nm[peaks[k]] / SIGMA_PER_FWHM + 1.5 * slit.gamma_nm
            full[k] = max(full[k], least / pitch)
    return full


@part_kernel
def _guess(x, y, peaks, first, full, pitch, slit):
    """Parameters, what they are pulled towards and how, and bounds; x in nm from the middle."""
    n = PER_PEAK * len(peaks) + PER_LINE
    p, lowest, highest = np.zeros(n), np.full(n, -np.inf), np.full(n, np.inf)
    pull = np.zeros(n)
    slit_nm, gamma_nm = slit.sigma_nm[peaks[0]], slit.gamma_nm
    for k in range(len(peaks)):
        at = PER_PEAK * k
        seen = full[k] * pitch
        top = peaks[k] - first
        height = max(y[top], 0.0)
        p[at] = VOIGT_AREA_PER_BOX * height * seen
        p[at + 1] = x[top]
        if slit_nm > 0.0:
            narrow = slit_nm / SIGMA_PER_FWHM
            p[at + 2] = slit_nm
            p[at + 3] = max(gamma_nm, 0.5 * (seen - narrow * narrow / seen))
            pull[at + 2] = 1.0 / (slit.sure * slit_nm) ** 2
            pull[at + 3] = 1.0 / (gamma_nm + slit.gamma_sure * slit_nm) ** 2
        else:
            p[at + 2] = GAUSSIAN_PART * SIGMA_PER_FWHM * seen
            p[at + 3] = LORENTZIAN_PART * 0.5 * seen
        lowest[at] = 0.0
        lowest[at + 1], highest[at + 1] = p[at + 1] - 0.6 * seen, p[at + 1] + 0.6 * seen
        lowest[at + 2], highest[at + 2] = NARROWEST * pitch, WIDEST * seen
        lowest[at + 3], highest[at + 3] = 0.0, WIDEST * seen
    toward = p.copy()
    for k in range(len(peaks)):
        if slit_nm > 0.0:
            toward[PER_PEAK * k + 3] = gamma_nm
    return p, toward, pull, lowest, highest


@kernel
def _fit_all(wavelength_nm, y, noise, peaks, slit, before, start):
    """Area, centre, sigma and gamma of the peaks, (4, n), their covariance, chi2, and what is settled."""
    n = len(peaks)
    fitted, covariance = np.zeros((PER_PEAK, n)), np.zeros((n, PER_PEAK, PER_PEAK))
    chi2, settled, known_before = np.zeros(n), np.zeros(n, np.bool_), np.zeros(n, np.bool_)
    full = _seen_widths(wavelength_nm, y, peaks, slit)
    k = 0
    for i in range(len(start.channels)):
        while k < n and peaks[k] < start.channels[i]:
            k += 1
        if k < n and peaks[k] == start.channels[i]:
            fitted[0, k], fitted[1, k] = start.area[i], start.centre_nm[i]
            fitted[2, k], fitted[3, k] = start.sigma_nm[i], start.gamma_nm[i]
    k = 0
    for i in range(len(before.channels)):
        while peaks[k] < before.channels[i]:
            k += 1
        fitted[0, k], fitted[1, k] = before.area[i], before.centre_nm[i]
        fitted[2, k], fitted[3, k] = before.sigma_nm[i], before.gamma_nm[i]
        chi2[k], settled[k], known_before[k] = before.chi2[i], before.settled[i], True
        for a in range(PER_PEAK):
            for b in range(PER_PEAK):
                covariance[k, a, b] = before.covariance[i, a, b]
    found = groups(y, peaks, full)
    for g in range(len(found)):
        first_peak, end_peak, first, end = found[g, 0], found[g, 1], found[g, 2], found[g, 3]
        n_fresh = 0
        for k in range(first_peak, end_peak):
            n_fresh += not known_before[k]
        if n_fresh == 0:
            continue
        middle = wavelength_nm[(first + end) // 2]
        x, weight, sureness = np.empty(end - first), np.empty(end - first), 0.0
        for i in range(end - first):
            x[i] = wavelength_nm[first + i] - middle
            weight[i] = 1.0 / (noise[first + i] * noise[first + i])
            sureness += weight[i] / (end - first)
        pitch = (x[-1] - x[0]) / max(len(x) - 1, 1)
        p, toward, pull, lowest, highest = _guess(
            x,
            y[first:end],
            peaks[first_peak:end_peak],
            first,
            full[first_peak:end_peak],
            pitch,
            slit,
        )
        for k in range(end_peak - first_peak):
            at = PER_PEAK * k
            if fitted[0, first_peak + k] > 0.0:
                for a in range(PER_PEAK):
                    begin = fitted[a, first_peak + k] - (middle if a == 1 else 0.0)
                    p[at + a] = min(max(begin, lowest[at + a]), highest[at + a])
        pull[-2] = sureness / LINE_NOISE**2
        pull[-1] = pull[-2] * (0.5 * (x[-1] - x[0])) ** 2
        total, hessian, done = fit(p, x, y[first:end], weight, toward, pull, lowest, highest)
        # A width that is pulled towards what is known takes up less than a free one.
        bound = 2 * (end_peak - first_peak) if slit.sigma_nm[peaks[first_peak]] > 0 else 0
        free = max(len(x) - len(p) + bound, 1)
        reduced = total / free
        lower = np.zeros(hessian.shape)
        known = factorise(hessian, lower)
        unit, column = np.zeros(len(p)), np.zeros(len(p))
        for k in range(end_peak - first_peak):
            at, peak = PER_PEAK * k, first_peak + k
            for a in range(PER_PEAK):
                fitted[a, peak] = p[at + a] + (middle if a == 1 else 0.0)
            chi2[peak], settled[peak] = reduced, done
            for a in range(PER_PEAK):
                unit[at + a] = 1.0
                if known:
                    solve(lower, unit, column)
                unit[at + a] = 0.0
                for b in range(PER_PEAK):
                    covariance[peak, a, b] = column[at + b] * max(reduced, 1.0) if known else np.nan
    return fitted, covariance, chi2, settled
