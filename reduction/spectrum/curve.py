"""Small loops over curves of many channels: running means, block values joined, quantiles.

numpy has all of them, for any shapes and steps; these exploit even steps, since there are many
spectra.
"""

import numpy as np

from .kernel import inner_kernel, kernel
from .spectrum import FloatArray

FINE = 4_096  # bins of the histogram that a middle is read from


@kernel
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


@kernel
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


@kernel
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


@kernel
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


@kernel
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


@kernel
def pitches(x):
    """Distance between neighbouring channels around each, shape (n,), n >= 2."""
    n = len(x)
    out = np.empty(n)
    out[0], out[n - 1] = x[1] - x[0], x[n - 1] - x[n - 2]
    for i in range(1, n - 1):
        out[i] = 0.5 * (x[i + 1] - x[i - 1])
    return out


@kernel
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


@inner_kernel
def put_in_place(values, place):
    """Swap values until the one at `place` is where sorting would put it; none may be NaN.

    (Hoare, Communications of the ACM 4, 321 (1961).)
    """
    low, high = 0, len(values) - 1
    while low < high:
        pivot, i, j = values[place], low, high
        while i <= j:
            while values[i] < pivot:
                i += 1
            while pivot < values[j]:
                j -= 1
            if i <= j:
                values[i], values[j] = values[j], values[i]
                i += 1
                j -= 1
        if j < place:
            low = i
        if place < i:
            high = j


@kernel
def quantile(values, q):
    """The quantile q (0 to 1) of values, linearly interpolated; NaN for none, and if one is NaN."""
    n = len(values)
    if n == 0:
        return np.nan
    parted = np.empty(n)
    for i in range(n):
        parted[i] = values[i]
        if values[i] != values[i]:
            return np.nan
    place = q * (n - 1)
    low = min(int(place), n - 1)
    put_in_place(parted, low)
    if low == n - 1:
        return parted[low]
    following = parted[low + 1]
    for i in range(low + 2, n):
        following = min(following, parted[i])
    return parted[low] + (place - low) * (following - parted[low])


@kernel
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
