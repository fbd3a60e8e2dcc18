"""Mark the channels that lie: without a number, dead, hot, or full.

A dead channel stays far below all that surrounds it. A hot one (or a cosmic ray) stands alone: a
line is wider than a channel, so its neighbours rise too. Full channels share one largest value.
"""

from dataclasses import dataclass

import numpy as np

from .noise import local_noise
from .spectrum import BoolArray, FloatArray

DEAD_SIGMA = 10.0
FLOOR_BLOCK = 64  # channels whose lower edge a dead one is held against
FLOOR_QUANTILE = 0.15
HOT_SIGMA = 8.0
HOT_SHOULDER = 0.1  # a line's neighbours rise by more than this part of its own rise
FULL_CHANNELS = 2  # next to each other, of exactly the largest value
FULL_SIGMA = 50.0  # that stands so far above the noise


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


def mark_bad(intensity: FloatArray) -> BadChannels:
    """Find the bad channels of counts (n,); NaN and infinite ones count as missing."""
    missing = ~np.isfinite(intensity)
    none = np.zeros(len(intensity), dtype=bool)
    if missing.all() or len(intensity) < 8:
        return BadChannels(missing, none, none.copy(), none.copy())
    y = bridged(intensity, missing)
    noise = local_noise(y)
    dead = _dead(y, noise)
    y = bridged(y, dead)
    hot = lone(y, noise)
    return BadChannels(missing, dead & ~missing, hot & ~missing, _full(y, noise) & ~missing & ~hot)


def bridged(intensity: FloatArray, bad: BoolArray) -> FloatArray:
    """The same counts with bad channels joined by straight lines. Raises ValueError if all are."""
    if not bad.any():
        return intensity
    if bad.all():
        raise ValueError("every channel of the spectrum is bad (NaN)")
    channel = np.arange(len(intensity))
    return np.interp(channel, channel[~bad], intensity[~bad])


def lone(y: FloatArray, noise: FloatArray) -> BoolArray:
    """Channels that stand out alone, as a cosmic ray does; shape (n,)."""
    found = np.zeros(len(y), dtype=bool)
    if len(y) < 5:
        return found
    left, middle, right = y[1:-3], y[2:-2], y[3:-1]
    rise = middle - np.maximum(left, right)
    shoulder = np.maximum(left - y[:-4], right - y[4:])
    found[2:-2] = (rise > HOT_SIGMA * noise[2:-2]) & (shoulder < HOT_SHOULDER * rise)
    return found


def _dead(y, noise):
    n = len(y) // FLOOR_BLOCK
    if n < 2:
        return np.zeros(len(y), dtype=bool)
    blocks = y[: n * FLOOR_BLOCK].reshape(n, FLOOR_BLOCK)
    place = int(FLOOR_QUANTILE * FLOOR_BLOCK)
    low = np.partition(blocks, place, axis=1)[:, place]
    floor = np.interp(np.arange(len(y)), (np.arange(n) + 0.5) * FLOOR_BLOCK, low)
    return y < floor - DEAD_SIGMA * noise


def _full(y, noise):
    top = y == y.max()
    if top.sum() < FULL_CHANNELS or y.max() - np.median(y) < FULL_SIGMA * float(np.median(noise)):
        return np.zeros(len(y), dtype=bool)
    beside = np.zeros(len(y), dtype=bool)
    beside[1:] |= top[:-1]
    beside[:-1] |= top[1:]
    return top & beside if (top & beside).any() else np.zeros(len(y), dtype=bool)
