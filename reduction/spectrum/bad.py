"""Mark bad channels: missing (NaN or infinite), dead, hot, or saturated.

A dead channel stays far below its surroundings. A hot one (or a cosmic ray) stands out alone: a line
is wider than a channel, so its neighbours rise too. Saturated channels share one largest value.
"""

from dataclasses import dataclass

import numpy as np

from .curve import bridge, joined, median
from .kernel import kernel
from .noise import noise_once
from .spectrum import BoolArray, FloatArray

DEAD_SIGMA = 10.0
FLOOR_BLOCK = 64  # channels whose lower edge a dead one is compared with
LOW_PLACE = int(0.15 * FLOOR_BLOCK)  # of its channels, from the lowest
HOT_SIGMA = 8.0
HOT_SHOULDER = 0.1  # a line's neighbours rise by more than this fraction of its own rise
PAIR_SIGMA, PAIR_SHOULDER = 25.0, 0.05  # the same of two channels that a cosmic ray shares
ALIKE = 3.0  # the brighter of the two over the other
FULL_CHANNELS = 2  # adjacent, with exactly the largest value
FULL_SIGMA = 50.0  # and this far above the noise


@dataclass(frozen=True, slots=True, eq=False)
class BadChannels:
    """Masks of shape (n,)."""

    missing: BoolArray
    dead: BoolArray
    hot: BoolArray
    full: BoolArray

    @property
    def any(self) -> BoolArray:
        return self.missing | self.dead | self.hot | self.full


def mark_bad(intensity: FloatArray, alone: bool = True) -> BadChannels:
    """Find the bad channels of counts (n,); NaN and infinite ones are missing.

    alone: also look for single channels (dead, hot). In an export interpolated from fewer channels, a
    bad one is spread over several, and every kink looks like one.
    """
    missing = ~np.isfinite(intensity)
    none = np.zeros(len(intensity), dtype=bool)
    if missing.all() or len(intensity) < 8:
        return BadChannels(missing, none, none.copy(), none.copy())
    y = bridged(intensity, missing)
    if missing.any():
        noise = np.zeros(len(y))  # a channel that was bridged has none of its own
        noise[~missing] = noise_once(y[~missing])
        noise = bridge(noise, missing)
    else:
        noise = noise_once(y)
    if not alone:
        return BadChannels(missing, none, none.copy(), _full(y, noise) & ~missing)
    dead = _dead(y, noise)
    y = bridged(y, dead)
    hot = lone(y, noise)
    return BadChannels(missing, dead & ~missing, hot & ~missing, _full(y, noise) & ~missing & ~hot)


def bridged(intensity: FloatArray, bad: BoolArray) -> FloatArray:
    """The counts with bad channels bridged by straight lines. Raises ValueError if all are bad."""
    if not bad.any():
        return intensity
    if bad.all():
        raise ValueError("every channel of the spectrum is bad (NaN)")
    return bridge(np.asarray(intensity, dtype=np.float64), bad)


def lone(y: FloatArray, noise: FloatArray) -> BoolArray:
    """Channels that stand out alone or in pairs, as a cosmic ray does; shape (n,)."""
    found = np.zeros(len(y), dtype=bool)
    _lone(y, noise, found)
    return found


@kernel
def _lone(y, noise, found):
    for i in range(2, len(y) - 2):
        rise = y[i] - max(y[i - 1], y[i + 1])
        if rise > HOT_SIGMA * noise[i]:
            shoulder = max(y[i - 1] - y[i - 2], y[i + 1] - y[i + 2])
            found[i] = found[i] or shoulder < HOT_SHOULDER * rise
        if i + 3 >= len(y):
            continue
        rise = min(y[i], y[i + 1]) - max(y[i - 1], y[i + 2])
        if rise > PAIR_SIGMA * noise[i] and max(y[i], y[i + 1]) < ALIKE * min(y[i], y[i + 1]):
            shoulder = max(abs(y[i - 1] - y[i - 2]), abs(y[i + 2] - y[i + 3]))
            if shoulder < PAIR_SHOULDER * rise:
                found[i] = found[i + 1] = True


@kernel
def _dead(y, noise):
    """Channels far below the lower edge of their block, and the edges of the next ones; (n,)."""
    n, dead = len(y) // FLOOR_BLOCK, np.zeros(len(y), np.bool_)
    if n < 2:
        return dead
    edge, least = np.empty(n), np.empty(LOW_PLACE + 1)
    for b in range(n):
        least.fill(np.inf)
        for i in range(b * FLOOR_BLOCK, (b + 1) * FLOOR_BLOCK):
            if y[i] >= least[LOW_PLACE]:
                continue
            k = LOW_PLACE  # the lowest so far, ascending: y[i] takes its place among them
            while k > 0 and y[i] < least[k - 1]:
                least[k] = least[k - 1]
                k -= 1
            least[k] = y[i]
        edge[b] = least[LOW_PLACE]
    floor = joined(edge, 0.5 * FLOOR_BLOCK, float(FLOOR_BLOCK), len(y))
    for i in range(len(y)):
        dead[i] = y[i] < floor[i] - DEAD_SIGMA * noise[i]
    return dead


def _full(y, noise):
    full = np.zeros(len(y), dtype=bool)
    top = float(y.max())
    at = np.flatnonzero(y == top)
    if len(at) < FULL_CHANNELS:
        return full
    if top - float(median(y)) < FULL_SIGMA * float(median(noise)):
        return full
    beside = np.diff(at) == 1
    full[at[:-1][beside]] = True
    full[at[1:][beside]] = True
    return full
