"""Move labels along a line as little as needed so that none overlaps its neighbour."""

import numpy as np

from ..spectrum.spectrum import FloatArray


def spread(places: FloatArray, apart: float, first: float, last: float) -> FloatArray:
    """Places (ascending) at least `apart` from each other, between first and last; shape (n,).

    The sum of squared moves is the least possible (isotonic regression by pooling neighbours). If
    all do not fit, they are spaced evenly.
    """
    n = len(places)
    if n and (n - 1) * apart > last - first:
        return np.linspace(first, last, n)
    shift = apart * np.arange(n)
    pools: list[list[float]] = []  # mean and number of members
    for value in np.asarray(places, dtype=np.float64) - shift:
        pools.append([float(value), 1.0])
        while len(pools) > 1 and pools[-2][0] > pools[-1][0]:
            mean, count = pools.pop()
            before, members = pools[-1]
            pools[-1] = [
                (before * members + mean * count) / (members + count), members + count
            ]  # fmt: skip
    level = np.concatenate([np.full(int(count), mean) for mean, count in pools] or [np.empty(0)])
    return np.clip(level, first, last - shift[-1] if n else last) + shift
