"""Limits of a scale that a few wild values do not set."""

from dataclasses import dataclass

import numpy as np

from ..spectrum.spectrum import FloatArray

BEYOND = 0.01  # of the values at either end, one at least, that may be wild
LEAST = 8  # fewer values have no wild ones
WILD = 1.5  # times the range of the others, from its other end, beyond which a value is wild


@dataclass(frozen=True, slots=True)
class Limits:
    """lowest and highest of the scale; how many values lie below and above it."""

    lowest: float
    highest: float
    below: int = 0
    above: int = 0

    @property
    def said(self) -> str:
        """`1 above`, `2 below, 3 above`; empty where all values lie on the scale."""
        parts = [f"{n} {word}" for n, word in ((self.below, "below"), (self.above, "above")) if n]
        return ", ".join(parts)


def robust_limits(values: FloatArray) -> Limits:
    """Limits of values of any shape, NaN ignored: theirs, without an end that stands far off.

    Values are left out that lie further off than half the range of all but the outermost hundredth
    (one value at least) at both ends. 0 to 1 where nothing is known.
    """
    known = np.sort(values[np.isfinite(values)], axis=None)
    if not len(known):
        return Limits(0.0, 1.0)
    if len(known) < LEAST:
        return Limits(float(known[0]), float(known[-1]))
    out = max(int(BEYOND * len(known)), 1)
    low, high = float(known[out]), float(known[-1 - out])
    reach = WILD * (high - low)
    if reach <= 0:
        return Limits(float(known[0]), float(known[-1]))
    inside = known[(known >= high - reach) & (known <= low + reach)]
    lowest, highest = float(inside[0]), float(inside[-1])
    return Limits(lowest, highest, int(np.sum(known < lowest)), int(np.sum(known > highest)))
