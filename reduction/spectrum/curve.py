"""Small loops over curves of many channels: running means, block values joined, quantiles.

numpy has all of them, for any shapes and steps; these exploit even steps, since there are many
spectra.
"""

import numpy as np

from .kernel import float_kernel
from .spectrum import FloatArray, IntArray

FEW = 32  # values, that are sorted as fast as parted
FINE = 4_096  # bins of the histogram that a middle is read from


@float_kernel
def joined(values, first, step, n):
    """Values at the channels first, first + step, ... joined by straight lines, shape (n,).

    The ends continue level. first may be between channels.
    """
    out = np.empty(n)
    last = len(values) - 1
    at = 0
    while at < n and at < first:
        out[at] = values[0]
        at += 1
    for k in range(last):
        begin = first + k * step
        slope = (values[k + 1] - values[k]) / step
        while at < n and at < begin + step:
            out[at] = values[k] + slope * (at - begin)
            at += 1
    while at < n:
        out[at] = values[last]
        at += 1
    return out


@float_kernel
def along(x, knots, values):
    """Values at ascending knots, joined by straight lines, at ascending places x; ends level."""
    out = np.empty(len(x))
    k, last = 0, len(knots) - 1
    for i in range(len(x)):
        while k < last and knots[k + 1] <= x[i]:
            k += 1
        if x[i] <= knots[0] or k == last:
            out[i] = values[k]
        else:
            part = (x[i] - knots[k]) / (knots[k + 1] - knots[k])
            out[i] = values[k] + part * (values[k + 1] - values[k])
    return out


@float_kernel
def bridge(values, bad):
    """The same values with bad channels joined by straight lines; some must be good; (n,)."""
    out = values.copy()
    n, before = len(values), -1
    i = 0
    while i < n:
        if not bad[i]:
            before = i
            i += 1
            continue
        end = i
        while end < n and bad[end]:
            end += 1
        for j in range(i, end):
            if before < 0:
                out[j] = values[end]
            elif end == n:
                out[j] = values[before]
            else:
                part = (j - before) / (end - before)
                out[j] = values[before] + part * (values[end] - values[before])
        i = end
    return out


@float_kernel
def even_means(values, width, first, step):
    """Means over `width` (odd) channels around first, first + step, ...; ends repeated."""
    n, half = len(values), width // 2
    n_out = max((n - first + step - 1) // step, 0)
    out = np.empty(n_out)
    for k in range(n_out):
        middle = first + k * step
        total = 0.0
        for i in range(middle - half, middle + half + 1):
            total += values[min(max(i, 0), n - 1)]
        out[k] = total / width
    return out


@float_kernel
def softened(values):
    """The mean of each channel (twice) and its two neighbours (once); ends repeated; (n,)."""
    n = len(values)
    out = np.empty(n)
    for i in range(1, n - 1):
        out[i] = 0.25 * values[i - 1] + 0.5 * values[i] + 0.25 * values[i + 1]
    if n > 1:
        out[0] = 0.75 * values[0] + 0.25 * values[1]
        out[n - 1] = 0.75 * values[n - 1] + 0.25 * values[n - 2]
    elif n == 1:
        out[0] = values[0]
    return out


@float_kernel
def pitches(x):
    """Distance between neighbouring channels around each, shape (n,), n >= 2."""
    n = len(x)
    out = np.empty(n)
    out[0], out[n - 1] = x[1] - x[0], x[n - 1] - x[n - 2]
    for i in range(1, n - 1):
        out[i] = 0.5 * (x[i + 1] - x[i - 1])
    return out


@float_kernel
def middle_within(values, reach):
    """The median of the values within +-reach, from a histogram; 0 if there are none.

    Accurate to about 2 reach / 4,096.
    """
    count = np.zeros(FINE, np.int64)
    scale = FINE / (2.0 * reach)
    inside = 0
    for v in values:
        if -reach < v < reach:
            count[min(int((v + reach) * scale), FINE - 1)] += 1
            inside += 1
    if inside == 0:
        return 0.0
    below, wanted = 0, 0.5 * inside
    for k in range(FINE):
        if below + count[k] >= wanted:
            return (k + (wanted - below) / count[k]) / scale - reach
        below += count[k]
    return reach


@float_kernel
def quantile(values, q):
    """The quantile q (0 to 1) of values, linearly interpolated; NaN for none."""
    n = len(values)
    if n == 0:
        return np.nan
    place = q * (n - 1)
    low = int(place)
    if n <= FEW:
        ordered = np.sort(values)
        if low >= n - 1:
            return ordered[n - 1]
        return ordered[low] + (place - low) * (ordered[low + 1] - ordered[low])
    parted = np.partition(values, min(low, n - 1))
    if low >= n - 1:
        return parted[n - 1]
    return parted[low] + (place - low) * (parted[low + 1 :].min() - parted[low])


@float_kernel
def median(values):
    """The median of values, shape (n,); NaN for none."""
    return quantile(values, 0.5)


def usual_pitch_nm(wavelength_nm: FloatArray) -> float:
    """The median distance of neighbouring channels, nm, from at most a thousand of them."""
    if len(wavelength_nm) < 2:
        return 1.0
    step = max(len(wavelength_nm) // 1_000, 1)
    return float(median(np.diff(wavelength_nm[::step]))) / step


def pitch_of(wavelength_nm: FloatArray) -> FloatArray:
    """Distance between neighbouring channels, nm, shape (n,); 1 for a single channel."""
    return pitches(wavelength_nm) if len(wavelength_nm) > 1 else np.ones(1)


def pitch_at(wavelength_nm: FloatArray, channels: IntArray) -> FloatArray:
    """The same at some of the channels, shape (k,)."""
    before = np.maximum(channels - 1, 0)
    after = np.minimum(channels + 1, len(wavelength_nm) - 1)
    if len(wavelength_nm) < 2:
        return np.ones(len(channels))
    return (wavelength_nm[after] - wavelength_nm[before]) / (after - before)
