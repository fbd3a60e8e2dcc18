"""Learn the instrument's line width and the noise of line light from the strongest lines.

A line is never narrower than the slit: among several strong lines, the narrow ones show its width.
"""

from dataclasses import dataclass

import numpy as np

from ..spectrum.curve import along, median, pitch_of, quantile
from ..spectrum.kernel import kernel
from ..spectrum.spectrum import FloatArray, IntArray
from .render import render
from .voigt import SIGMA_PER_FWHM, Slit, VoigtPeaks, fit_peaks

MOST_TAUGHT = 80  # lines that are looked at
STRONG = 15.0  # height in noise
NARROW_QUANTILE = 0.35
# A peak this much wider than narrow ones is no line; an echelle's lines widen fivefold along its axis.
NARROWEST_QUANTILE, NO_LINE = 0.15, 15.0
NEAREST = 7  # strong lines that speak for a place
USUAL_FWHM_CHANNELS = 3.0  # where no line tells
KNOWN = 0.2  # error of a Gaussian width, as a part of it, up to which it counts
SURE = 0.04, 0.25  # limits of how well the slit is known, as a part of it
TAKEN_UP = 1.8  # five residuals on a top are smaller than noise: the fit has followed them
QUIET_LINES = 0.3
LEAST_LINES = 4


@dataclass(frozen=True, slots=True, eq=False)
class Taught:
    """slit: widths; gain: variance of a channel (counts^2) for each count of line light.

    lines: the channels of the lines used, and their fits.
    """

    slit: Slit
    gain: float | None  # None: too few lines to tell
    lines: tuple[IntArray, VoigtPeaks] | None = None


def learn(wavelength_nm: FloatArray, net: FloatArray, noise: FloatArray, peaks: IntArray) -> Taught:
    """The slit and the gain, from the strongest peaks (channels, ascending); shapes (m,)."""
    chosen = _strongest(net, noise, peaks)
    pitch = pitch_of(wavelength_nm)
    if not len(chosen):
        return Taught(Slit(USUAL_FWHM_CHANNELS * SIGMA_PER_FWHM * pitch, 0.0, 0.5), None)
    fitted = fit_peaks(wavelength_nm, net, noise, chosen)
    good = fitted.settled & (fitted.fwhm_nm > 1.2 * pitch[chosen])
    good &= fitted.sigma_nm > 0.3 * pitch[chosen]
    if good.any():  # a waving continuum has peaks, too
        narrow = float(quantile(fitted.fwhm_nm[good], NARROWEST_QUANTILE))
        good &= fitted.fwhm_nm < NO_LINE * narrow
    gain = _gain(wavelength_nm, net, noise, chosen, fitted)
    if not good.any():
        return Taught(
            Slit(USUAL_FWHM_CHANNELS * SIGMA_PER_FWHM * pitch, 0.0, 0.5), gain, (chosen, fitted)
        )
    return Taught(_slit(wavelength_nm, fitted, np.flatnonzero(good)), gain, (chosen, fitted))


def _strongest(net, noise, peaks):
    height = net[peaks] / noise[peaks]
    strong = peaks[height > STRONG]
    if len(strong) <= MOST_TAUGHT:
        return strong
    # Of each stretch of the spectrum the strongest, so that every segment has its teachers.
    stretches = np.array_split(strong, 8)
    each = MOST_TAUGHT // 8
    best = [part[np.argsort(net[part] / noise[part])[-each:]] for part in stretches]
    return np.sort(np.concatenate(best))


def _slit(wavelength_nm, fitted: VoigtPeaks, good) -> Slit:
    """Local low quantile of the Gaussian widths that are well known, joined by straight lines."""
    sigma = fitted.sigma_nm[good]
    error = np.sqrt(np.maximum(fitted.covariance[good, 2, 2], 0.0))
    known = error < KNOWN * sigma
    if known.sum() < 3:
        known = error <= np.sort(error)[min(2, len(error) - 1)]
    centre, sigma = fitted.centre_nm[good][known], sigma[known]
    order = np.argsort(centre)
    centre, sigma = centre[order], sigma[order]
    n = min(NEAREST, len(centre))
    first = np.clip(np.arange(len(centre)) - n // 2, 0, len(centre) - n)
    windows = sigma[first[:, None] + np.arange(n)]
    narrow, spread = _narrow_and_spread(windows)
    sure = min(max(float(median(spread / narrow)), SURE[0]), SURE[1])
    return Slit(along(wavelength_nm, centre, narrow), float(median(fitted.gamma_nm[good])), sure)


def _gain(wavelength_nm, net, noise, peaks, fitted: VoigtPeaks) -> float | None:
    """The gain that explains the residuals on the tops of the better fitted lines.

    A blend or a line that is not a Voigt profile leaves more than noise, so a low quantile is used.
    """
    if len(peaks) < LEAST_LINES:
        return None
    left, light = on_tops(net, render(wavelength_nm, fitted, 0.5 * noise), peaks)
    each = (TAKEN_UP * left - noise[peaks] ** 2) / np.maximum(light, 1e-30)
    return max(float(quantile(each, QUIET_LINES)), 0.0)


@kernel
def on_tops(net, model, tops):
    """Mean square of what a model leaves over on the five channels of each top, and its mean; (k,)."""
    square, light, last = np.zeros(len(tops)), np.zeros(len(tops)), len(net) - 1
    for k in range(len(tops)):
        for i in range(tops[k] - 2, tops[k] + 3):
            at = min(max(i, 0), last)
            square[k] += 0.2 * (net[at] - model[at]) ** 2
            light[k] += 0.2 * model[at]
    return square, light


@kernel
def _narrow_and_spread(windows):
    """A low quantile of each row, and its median distance from its median; shapes (n,)."""
    narrow, spread = np.empty(len(windows)), np.empty(len(windows))
    away = np.empty(windows.shape[1])
    for k in range(len(windows)):
        narrow[k], middle = quantile(windows[k], NARROW_QUANTILE), median(windows[k])
        for i in range(len(away)):
            away[i] = abs(windows[k, i] - middle)
        spread[k] = median(away)
    return narrow, spread
