"""Average channels that are much finer than the lines, so that windows of channels fit any axis.

All further steps count in channels: noise of neighbours, spikes of one channel, wings of a line. An
axis of a million channels, on which a line is hundreds wide, is averaged first; channels finer than
any plasma spectrograph's at once, the rest when the widths of the lines are known.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..spectrum.bad import BadChannels, bridged, mark_bad
from ..spectrum.curve import median, quantile, softened
from ..spectrum.kernel import kernel
from ..spectrum.noise import local_noise
from ..spectrum.resampled import WHITE, sharing
from ..spectrum.spectrum import BoolArray, FloatArray, Spectrum
from .peaks import SOFTENED_NOISE
from .profiles import Profiles, fit_profiles
from .voigt import SIGMA_PER_FWHM

FINEST = 150_000.0  # wavelength over pitch: an echelle of 75,000 with two channels a line
# Full widths in channels: too many, and what to come to; less surely where few lines tell.
WIDE, ENOUGH = 9.0, 4.5
WIDE_OF_FEW, ENOUGH_OF_FEW, FEW = 16.0, 7.0, 5
CLEAR, NARROW = 10.0, 0.2  # errors of an area; quantile of the widths of such peaks
OVER_NARROW = 2.5  # usual width over that of the narrower ones
LEAST_WIDE = 2.0  # a detector's own channels that a line is wide
BRIGHTEST, BASE, BASE_QUANTILE = (
    20,
    60,
    0.25,
)  # maxima; channels beside them, whose quantile is their foot
EXACT, INTERPOLATED = 1e-9, 0.15  # of a usual step; part of the channels
LEAST_LEFT = 64  # channels
PHOTON_CHANNELS, BLURRED_PHOTON = (
    4,
    2,
)  # hold whole photons: as they are, and of means already taken
PHOTON_TAIL = 2.0  # noise over what is seen of it


@dataclass(frozen=True, slots=True, eq=False)
class Averaged:
    """A spectrum of fewer channels, which of them count for nothing, (m,), and how many were one."""

    spectrum: Spectrum
    bad: BoolArray
    channels: int


def averaged(spectrum: Spectrum, bad: BadChannels, channels: int) -> Averaged:
    """Means of `channels` neighbours, wavelengths (nm) and counts alike.

    Bad channels are left out of a mean; a saturated one spoils it, since its line is cut off.
    """
    if channels <= 1:
        return Averaged(spectrum, bad.any, 1)
    out = bad.missing | bad.dead | bad.hot
    x, y, none = _means(spectrum.wavelength_nm, spectrum.intensity, out, bad.full, channels)
    return Averaged(Spectrum(x, bridged(y, np.isnan(y))), none, channels)


def fit_at_pitch(
    spectrum: Spectrum,
    bad: BadChannels,
    wanted_nm: FloatArray | None = None,
    shared: int = 1,
) -> tuple[Profiles, int]:
    """The peaks, on channels no finer than their widths need, and how many were averaged into one.

    wanted_nm: as in `fit_profiles`. shared: channels that share their noise, see `resampled`. The
    axis that was used is in the profiles.
    """
    coarse = shared > 1 and LEAST_WIDE * shared > narrow_channels(spectrum.intensity, bad.any)
    # Smoothed, not interpolated: the lines are as narrow as the smoothing.
    smoothed = coarse and not on_straight_lines(spectrum.intensity)
    finest = finer_than_any(spectrum.wavelength_nm)
    seen = averaged(spectrum, bad, finest if smoothed else max(finest, shared))
    hidden = 1.0
    if shared > 1:
        hidden = max(sharing(seen.spectrum.intensity) / WHITE, 1.0)
    wider, lag = hidden, 1
    if smoothed:
        lag = 2 * shared
        wider = max(softening_leaves(bridged(seen.spectrum.intensity, seen.bad), lag), 1.0)
    if shared > 1 and not smoothed:
        spoiled = seen.bad | mark_bad(seen.spectrum.intensity).any
        seen = Averaged(seen.spectrum, spoiled, seen.channels)
    profiles = fit_profiles(seen.spectrum, seen.bad, wanted_nm, wider, lag)
    if profiles.spikes:
        # Their sums over several channels are nearly normal, but for a tail.
        whole = PHOTON_CHANNELS if shared == 1 else BLURRED_PHOTON
        seen = averaged(spectrum, bad, seen.channels * whole)
        hidden *= PHOTON_TAIL
        profiles = fit_profiles(seen.spectrum, seen.bad, wanted_nm, hidden)
        profiles = replace(profiles, spikes=True)
    more = 1 if profiles.spikes else too_fine(profiles)
    if more > 1:
        seen = averaged(spectrum, bad, seen.channels * more)
        profiles = fit_profiles(seen.spectrum, seen.bad, wanted_nm, wider, -(-lag // more))
    return profiles, seen.channels


def softening_leaves(intensity: FloatArray, lag: int) -> float:
    """How much more noise the smoothing, with which peaks are sought, leaves than of white noise.

    lag: channels from which on neighbours share no noise.
    """
    before, after = local_noise(intensity, lag=lag), local_noise(softened(intensity), lag=lag)
    return float(median(after / before)) / SOFTENED_NOISE


def finer_than_any(x: FloatArray) -> int:
    """How many channels of an axis (nm, ascending) make one at the finest real pitch."""
    if len(x) <= LEAST_LEFT:
        return 1
    pitch_nm = (x[-1] - x[0]) / (len(x) - 1)
    return max(min(int(0.5 * (x[0] + x[-1]) / FINEST / pitch_nm), len(x) // LEAST_LEFT), 1)


def too_fine(profiles: Profiles) -> int:
    """How many channels to average, from the widths of strong lines."""
    x = profiles.wavelength_nm
    if not len(profiles.peaks):
        return 1
    slit = profiles.slit
    pitch_nm = (x[-1] - x[0]) / max(len(x) - 1, 1)
    sigma_nm = float(median(slit.sigma_nm[:: max(len(x) // 200, 1)].copy()))
    width = (sigma_nm / SIGMA_PER_FWHM + slit.gamma_nm) / pitch_nm
    width = min(width, OVER_NARROW * narrow_nm(profiles) / pitch_nm)
    wide, enough = (WIDE, ENOUGH) if len(profiles.peaks) >= FEW else (WIDE_OF_FEW, ENOUGH_OF_FEW)
    if width < wide:
        return 1
    return max(min(int(width / enough), len(x) // LEAST_LEFT), 1)


def narrow_nm(profiles: Profiles) -> float:
    """Full width of the narrower lines; a waving continuum has wide peaks beside them."""
    peaks = profiles.peaks
    clear = peaks.area > CLEAR * peaks.area_error
    widths = peaks.fwhm_nm[clear] if np.count_nonzero(clear) >= FEW else peaks.fwhm_nm
    return float(quantile(widths, NARROW))


def on_straight_lines(intensity: FloatArray) -> bool:
    """Whether many channels lie exactly between their neighbours, as interpolated ones do."""
    bend = np.abs(np.diff(intensity, 2))
    step = float(np.nanmedian(np.abs(np.diff(intensity)))) if len(intensity) > 2 else 0.0
    return float(np.mean(bend <= EXACT * step)) > INTERPOLATED


def narrow_channels(intensity: FloatArray, bad: BoolArray) -> float:
    """Full width at half height of the narrower of the brightest maxima, channels; infinite without any.

    intensity: counts, shape (n,); bad: channels that do not count, (n,).
    """
    y = bridged(intensity, bad)
    top = 1 + np.flatnonzero((y[1:-1] >= y[:-2]) & (y[1:-1] > y[2:]))
    widths: list[float] = []
    last = np.zeros(len(y), np.bool_)
    for at in top[np.argsort(-y[top])].tolist():
        if last[at]:
            continue
        near = y[max(at - BASE, 0) : at + BASE + 1]
        half = 0.5 * (y[at] + float(quantile(near, BASE_QUANTILE)))
        below = np.flatnonzero(near <= half) + max(at - BASE, 0)
        left, right = below[below < at], below[below > at]
        if not len(left) or not len(right):
            continue
        a, b = int(left[-1]), int(right[0])
        last[a : b + 1] = True
        widths.append(b - a - (half - y[a]) / (y[a + 1] - y[a]) - (half - y[b]) / (y[b - 1] - y[b]))
        if len(widths) == BRIGHTEST:
            break
    return float(quantile(np.array(widths), NARROW)) if widths else np.inf


@kernel
def _means(x, y, out, full, channels):
    n = len(x)
    m = (n + channels - 1) // channels
    nm, counts, none = np.empty(m), np.empty(m), np.zeros(m, np.bool_)
    for k in range(m):
        begin, end = k * channels, min((k + 1) * channels, n)
        place, light, good = 0.0, 0.0, 0
        for i in range(begin, end):
            place += x[i]
            none[k] = none[k] or full[i]
            if not out[i]:
                light += y[i]
                good += 1
        nm[k] = place / (end - begin)
        counts[k] = light / good if good > 0 else np.nan
        none[k] = none[k] or good == 0
    return nm, counts, none
