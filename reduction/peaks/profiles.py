"""Find and fit a spectrum's lines: learn from strong ones, fit all, search the residual."""

from dataclasses import dataclass, replace

import numpy as np

from ..spectrum.bad import bridged, mark_bad
from ..spectrum.curve import bridge, median, quantile, softened
from ..spectrum.kernel import kernel
from ..spectrum.noise import (
    QUANTILE,
    SIGMA_PER_QUANTILE,
    above_0,
    cut_off,
    noise_apart,
    steadied,
)  # fmt: skip
from ..spectrum.resampled import sharing
from ..spectrum.response import KnownResponse
from ..spectrum.spectrum import BoolArray, FloatArray, IntArray, Spectrum
from .background import lifted, lower_edge
from .merge import merged, significant
from .peaks import SIGNIFICANT, SOFTENED_NOISE, clear_of, find_peaks, standing_out
from .render import render
from .slit import QUIET_LINES, TAKEN_UP, Slit, learn, on_tops
from .spikes import has_spikes
from .voigt import SIGMA_PER_FWHM, VoigtPeaks, among, fit_peaks

RESIDUAL = 4.5  # a peak in what the first fit left over, in noise
FOREIGN = (
    0.04  # and as a part of the light around it: no line is a Voigt profile to the last percent
)
NEVER_DROPPED = 10.0  # prominence in noise
DEAF = 1e3  # what the noise of a bad channel is multiplied by in a fit
FOLLOWED, CLEARLY = 1.15, 0.7
# Noise over what neighbours tell of it: 2.3 for means of three channels, 3 to 7 behind an intensifier.
SMEARED = 3.0
CROWDED = 0.2  # part of the peaks with clearly less noise, from which all is fitted anew
LEAST_TOPS, QUIET_STEP, QUIET_PART = 30, 50, 0.1
WANTED, WANTED_NM = 3.0, 0.3
ONE_SIGMA = 0.6827  # part of half a normal law within one standard deviation
DIPS, FEW_DIPS = 0.3, 2  # as a part of the peaks, and at all: fewer are no sign of noise
OFTEN_CUT, BESIDE, LEAST_BESIDE = 0.2, 4, 200  # part of the channels; channels
LOOSE, LEAST_STEP, MOST_TURNS = 4.0, 1.1, 8
WAVES, OWN, CLOSER_NM, FOLLOWS = 2.0, 1.0, 0.8, 0.6
APART = 0.55  # of a slit's width from the next peak


@dataclass(frozen=True, slots=True, eq=False)
class Profiles:
    """Fitted peaks and what they were fitted to; arrays of shape (m,) in counts.

    counts: with bad channels bridged. net: above the background `under`. noise: of each channel,
    with that of the lines' own light. gain: variance a count of light. wavelength_nm: of the
    channels; bad: those without influence. spikes: whether many peaks are narrower than a line.
    """

    peaks: VoigtPeaks
    counts: FloatArray
    net: FloatArray
    under: FloatArray
    noise: FloatArray
    slit: Slit
    gain: float
    wavelength_nm: FloatArray
    bad: BoolArray
    spikes: bool = False

    def over(self, known: KnownResponse) -> "Profiles":
        """The same with a response divided out of all that is in counts, but for `gain`."""
        at, of_peak = known.at(self.wavelength_nm), known.at(self.peaks.centre_nm)
        covariance = self.peaks.covariance.copy()
        covariance[:, 0, :] /= of_peak[:, None]
        covariance[:, :, 0] /= of_peak[:, None]
        return replace(
            self,
            peaks=replace(self.peaks, area=self.peaks.area / of_peak, covariance=covariance),
            counts=self.counts / at, net=self.net / at, under=self.under / at, noise=self.noise / at,
        )  # fmt: skip


def fit_profiles(
    spectrum: Spectrum,
    bad: BoolArray | None = None,
    wanted_nm: FloatArray | None = None,
    hidden: float = 1.0,
    lag: int = 1,
) -> Profiles:
    """All peaks of a spectrum, ascending in their centres.

    bad: channels that do not count, shape (m,); found by `mark_bad` if None. wanted_nm: places
    on the axis, ascending, at which a peak of three times the noise is enough.
    hidden: factor for the noise estimated from neighbours that share some of it. lag: channels
    from which on they share none.
    """
    x = spectrum.wavelength_nm
    bad = mark_bad(spectrum.intensity).any if bad is None else bad
    calm = Spectrum(x, bridged(spectrum.intensity, bad))
    apart = _noise_of_good(calm.intensity, bad, lag)
    followed = lag > 1 and _followed(apart, _noise_of_good(calm.intensity, bad, 1))
    floor = hidden * apart
    edge = lower_edge(calm)
    under = lifted(calm, edge, floor)
    steady = steadied(floor, under)
    wider = by_dips(calm, edge, steady.sigma, bad)
    if wider > WAVES and sharing(calm.intensity) < OWN:
        # Neighbours share no noise, so the continuum has waves that the background should follow.
        closer = lower_edge(calm, CLOSER_NM)
        less = by_dips(calm, closer, steady.sigma, bad)
        if less < FOLLOWS * wider:
            edge, wider = closer, less
            under = lifted(calm, edge, steady.sigma)
    floor = steady.sigma * wider
    under = lifted(calm, edge, floor) if wider > 1.0 else under
    net = calm.intensity - under
    soft = softened(net)
    seeds = standing_out(soft, floor)[0]
    spikes = has_spikes(net, seeds)
    deaf = np.where(bad, DEAF, 1.0) if bad.any() else 1.0
    taught = learn(x, net, floor * deaf if bad.any() else floor, seeds)
    gain = min((g for g in (taught.gain, steady.gain) if g is not None), default=0.0)
    noise = _with_light(floor, gain, soft)
    heard = noise * deaf if bad.any() else noise
    seeds = _seeds(x, soft, noise, wanted_nm)
    peaks = fit_peaks(x, net, heard, seeds, taught.slit, start=taught.lines)
    model = render(x, peaks, 0.05 * noise)
    quieter = noise
    if not followed:
        left, _ = on_tops(net, model, seeds)
        quieter = quieter_noise(noise, floor, above_0(under), soft, left, seeds)
    crowded = quieter is not noise
    if crowded:
        noise, heard = quieter, quieter * deaf
    more = search_residual(x, net, model, heard, peaks, taught.slit)
    more = np.concatenate([more, standing_out(soft, noise)[0]]) if crowded else more
    if len(more):
        there = np.zeros(len(x), dtype=np.bool_)
        there[seeds] = there[more] = True
        both = np.flatnonzero(there)
        before = None if crowded else (seeds, peaks)
        peaks = fit_peaks(x, net, heard, both, taught.slit, before, (seeds, peaks))
    else:
        both = seeds
    clear = clear_of(soft, noise, both)
    kept, peaks = merged(x, net, heard, both, clear, peaks, taught.slit)
    both, clear = kept, clear[among(both, kept)]
    sure = among(both, seeds) & (clear > NEVER_DROPPED) & ~bad[both]
    real = np.flatnonzero(significant(peaks) | (sure & (peaks.area > 0.0)))
    order = real[np.argsort(peaks.centre_nm[real], kind="stable")]
    return Profiles(
        peaks.where(order), calm.intensity, net, under, noise, taught.slit, gain, x, bad, spikes
    )


def by_dips(calm: Spectrum, edge: FloatArray, noise: FloatArray, bad: BoolArray) -> float:
    """How much larger the noise is than neighbouring channels tell, usually 1.

    Light is never negative: where there are dips below the background as there are peaks, both are
    noise that neighbours share (a smoothed export), or waves of the continuum. How far the smoothed
    counts go below says how large it is. Where dips were cut off, what is left beside them says it.
    edge: below the noise; all of shape (m,), counts.
    """
    wider = _beside_cut(calm.intensity, noise, bad)
    for _ in range(MOST_TURNS):
        wide = wider * noise
        soft = softened(calm.intensity - lifted(calm, edge, LOOSE * wide))
        tops, dips = (len(standing_out(side, wide)[0]) for side in (soft, -soft))
        if dips <= max(DIPS * tops, FEW_DIPS):
            break
        z = soft[~bad] / (noise[~bad] * SOFTENED_NOISE)
        wider = max(float(quantile(-z[z < 0.0], ONE_SIGMA)), LEAST_STEP * wider)
    return wider


def _beside_cut(y: FloatArray, noise: FloatArray, bad: BoolArray) -> float:
    """How much larger the noise is than neighbouring channels tell, by what rises beside cut channels."""
    cut = cut_off(y)
    if np.mean(cut) < OFTEN_CUT:
        return 1.0
    beside = np.convolve(cut, np.ones(2 * BESIDE + 1), "same") > 0.5
    left = beside & ~cut & ~bad
    if np.count_nonzero(left) < LEAST_BESIDE:
        return 1.0
    above = (y[left] - y[cut][0]) / noise[left]
    return max(float(quantile(above, QUANTILE)) * SIGMA_PER_QUANTILE, 1.0)


def _noise_of_good(y: FloatArray, bad: BoolArray, lag: int) -> FloatArray:
    """Noise from the good channels: bridged channels have none."""
    if not bad.any():
        return noise_apart(y, lag)
    noise = np.zeros(len(y))
    noise[~bad] = noise_apart(y[~bad], lag)
    return bridge(noise, bad)


def _seeds(x, soft, noise, wanted_nm) -> IntArray:
    """Channels of peaks, ascending; at requested positions fainter ones too."""
    if wanted_nm is None or not len(wanted_nm):
        return standing_out(soft, noise)[0]
    channels, clear = standing_out(soft, noise, WANTED)
    at = x[channels]
    near = np.searchsorted(wanted_nm, at - WANTED_NM) < np.searchsorted(wanted_nm, at + WANTED_NM)
    return channels[(clear >= SIGNIFICANT) | near]


def _followed(apart: FloatArray, near: FloatArray) -> bool:
    """Whether a fit follows the noise so far that what it leaves over tells nothing of it.

    apart, near: the noise by channels that share none and by neighbours, counts, both (n,).
    """
    return float(median(apart / np.maximum(near, 1e-300))) > SMEARED


def quieter_noise(
    noise: FloatArray,
    floor: FloatArray,
    under: FloatArray,
    soft: FloatArray,
    left: FloatArray,
    seeds: IntArray,
) -> FloatArray:
    """The noise where crowded lines had been taken for some of it, counts, (m,); else the same array.

    under, soft: light of the continuum and of lines; seeds: channels of peaks; left: mean square of
    what the fit left over on each, (k,). The better fitted tops and the quietest stretch of the axis
    show variance = read^2 + gain * light. A fit follows part of the noise, hence TAKEN_UP; a blend
    leaves more, hence a low quantile.
    """
    if len(seeds) < LEAST_TOPS:
        return noise
    read = float(quantile(floor[::QUIET_STEP].copy(), QUIET_PART)) ** 2
    light = under[seeds] + soft[seeds]
    each = TAKEN_UP * left - read
    gain = max(float(quantile(each / np.maximum(light, 1e-30), QUIET_LINES)), 0.0)
    at_tops = FOLLOWED * np.sqrt(read + gain * np.maximum(light, 0.0))
    if np.mean(at_tops < CLEARLY * noise[seeds]) <= CROWDED:
        return noise
    again = FOLLOWED * np.sqrt(read + gain * np.maximum(under + soft, 0.0))
    return np.where(again < CLEARLY * noise, again, noise)


def search_residual(
    x: FloatArray,
    net: FloatArray,
    model: FloatArray,
    noise: FloatArray,
    peaks: VoigtPeaks,
    slit: Slit,
) -> IntArray:
    """Channels of peaks in what the fitted peaks (drawn: model) leave over, ascending."""
    if not len(peaks):
        return np.empty(0, dtype=np.int64)
    tolerated = _tolerated(noise, model)
    found = find_peaks(net - model, tolerated, RESIDUAL)
    if not len(found):
        return found
    near = np.abs(peaks.centre_nm[:, None] - x[found]).min(axis=0)
    before, after = np.maximum(found - 1, 0), np.minimum(found + 1, len(x) - 1)
    pitch = (x[after] - x[before]) / (after - before)
    return found[near > np.maximum(APART * slit.sigma_nm[found] / SIGMA_PER_FWHM, pitch)]


@kernel
def _with_light(floor, gain, soft):
    """The noise, counts, (m,), with that of the lines' own light."""
    out = np.empty(len(floor))
    for i in range(len(floor)):
        out[i] = np.sqrt(floor[i] * floor[i] + gain * max(soft[i], 0.0))
    return out


@kernel
def _tolerated(noise, model):
    """Noise, and what a profile may be off by where any of three channels is bright, counts, (m,)."""
    out, last = np.empty(len(noise)), len(noise) - 1
    for i in range(len(noise)):
        widest = max(model[max(i - 1, 0)], model[i], model[min(i + 1, last)])
        wrong = FOREIGN / RESIDUAL * 2 * widest
        out[i] = np.sqrt(noise[i] * noise[i] + wrong * wrong)
    return out
