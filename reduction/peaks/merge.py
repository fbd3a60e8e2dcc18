"""Merge profiles that share one line: the pair has its area, but neither of them a known part.

Two Voigt profiles within a line's width fit it better than one, since no line is one to the last
percent; then 361 +- 9,844 and 1,238 +- 9,813 counts nm are what each is said to have, and both would
be dropped as insignificant. One is taken away, and the other fitted again.
"""

import numpy as np

from ..spectrum.spectrum import BoolArray, FloatArray, IntArray
from .voigt import Slit, VoigtPeaks, fit_peaks

LEAST_AREA = 2.0  # in its own error: what the fit makes smaller was no peak
STANDS = 5.0  # height of a drawn profile in noise, from which its area should be known
TOGETHER = 1.0  # widths between profiles of one line
NEAR = 4.0  # widths around a merged line in which all is fitted again
MOST_TURNS = 6
BOX_PER_AREA = 1.2  # area / (height * full width) of a Voigt profile, roughly


def significant(peaks: VoigtPeaks) -> BoolArray:
    """Which areas stand clear of their own errors; (n,). An unknown error does not."""
    return peaks.area > LEAST_AREA * peaks.area_error


def merged(
    x: FloatArray,
    net: FloatArray,
    noise: FloatArray,
    channels: IntArray,
    prominence: FloatArray,
    peaks: VoigtPeaks,
    slit: Slit,
) -> tuple[IntArray, VoigtPeaks]:
    """The channels and peaks that remain when no line is shared any longer.

    x, net, noise: nm and counts, (m,). channels, prominence (in noise; 0 for a peak that was only
    found in the residual) and peaks: what was fitted, (n,), in the same order. Of those that share
    a line, the most prominent stays.
    """
    for _ in range(MOST_TURNS):
        spare = _spare(noise, channels, prominence, peaks)
        if not spare.any():
            break
        touched = np.zeros(len(channels), dtype=bool)
        width = peaks.fwhm_nm
        for k in np.flatnonzero(spare):
            touched |= np.abs(x[channels] - x[channels[k]]) < NEAR * np.maximum(width, width[k])
        still, same = ~spare, ~spare & ~touched
        before = (channels[same], peaks.where(same))
        channels, prominence = channels[still], prominence[still]
        peaks = fit_peaks(x, net, noise, channels, slit, before)
    return channels, peaks


def _spare(noise, channels, prominence, peaks: VoigtPeaks) -> BoolArray:
    """One profile of each line that several share, the least prominent."""
    unknown = ~significant(peaks)
    if np.count_nonzero(unknown) < 2:  # as in most spectra
        return np.zeros(len(channels), dtype=bool)
    width = np.maximum(peaks.fwhm_nm, 1e-9)
    height = peaks.area / (BOX_PER_AREA * width) / noise[channels]
    vague = unknown & (height > STANDS)
    spare = np.zeros(len(channels), dtype=bool)
    order = np.flatnonzero(vague)[np.argsort(peaks.centre_nm[vague])]
    run: list[int] = []
    for k in [*order.tolist(), -1]:
        if run and k >= 0:
            last = run[-1]
            # The broad one of a pair is a foot of the line, not another line.
            reach = TOGETHER * max(width[k], width[last])
            if peaks.centre_nm[k] - peaks.centre_nm[last] < reach:
                run.append(k)
                continue
        if len(run) > 1:
            spare[run[int(np.argmin(prominence[run]))]] = True
        run = [k]
    return spare
