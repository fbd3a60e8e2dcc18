"""Shots of one standard: their mean, how they scatter, and which of them are outliers."""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from ..spectrum.spectrum import BoolArray, FloatArray

OUTLYING = 4.5  # robust standard deviations from the median of the standard's shots
OWN = 1.5  # as much more than the pooled distance may a standard's own be: it holds the outlier
LEAST_SHOTS = 4  # fewer tell no outlier
MAD = 1.4826


def outliers(signals: Sequence[FloatArray], noise: Sequence[FloatArray]) -> list[BoolArray]:
    """Which shots of each standard are far from its median, one array for each standard.

    The usual distance is pooled over all standards: that of five shots alone says little.
    """
    middle = [float(np.median(one)) if len(one) else 0.0 for one in signals]
    away = [np.abs(one - m) for one, m in zip(signals, middle, strict=True)]
    parts = [
        distance / abs(m)
        for distance, m, own in zip(away, middle, noise, strict=True)
        if len(distance) >= LEAST_SHOTS and abs(m) > 5 * float(np.median(own))
    ]
    part = MAD * float(np.median(np.concatenate(parts))) if parts else 0.0
    far = []
    for distance, m, own in zip(away, middle, noise, strict=True):
        alone = MAD * float(np.median(distance)) if len(distance) else 0.0
        pooled = np.sqrt(own**2 + (part * m) ** 2)
        usual = np.clip(alone, pooled, OWN * pooled)
        out = distance > OUTLYING * usual
        # Half of the shots or more are no outliers of the others: the standard itself scatters so.
        some = len(distance) >= LEAST_SHOTS and 2 * np.count_nonzero(out) < len(distance)
        far.append(out & some)
    return far


def shot_scatter(signals: Sequence[FloatArray], noise: Sequence[FloatArray]) -> tuple[float, float]:
    """How a shot scatters: a floor in the signal's unit, and a part of the signal.

    The variances of all standards' shots by mean signal squared, weighted; without replicates the
    noise of the spectra alone.
    """
    quiet = float(np.median(np.concatenate(list(noise))))
    several = [one for one in signals if len(one) > 1]
    if not several:
        return quiet, 0.0
    mean = np.array([np.mean(one) for one in several])
    variance = np.array([np.var(one, ddof=1) for one in several])
    weight = np.sqrt([len(one) - 1.0 for one in several])
    usual = np.maximum(variance, quiet**2)
    found = np.zeros(2)
    for _ in range(5):
        rows = np.column_stack([np.ones(len(mean)), mean**2]) * (weight / usual)[:, None]
        size = np.maximum(rows.max(axis=0), 1e-300)
        found = nnls(rows / size, variance * weight / usual)[0] / size
        usual = np.maximum(found[0] + found[1] * mean**2, quiet**2)
    return float(max(found[0] ** 0.5, quiet)), float(found[1] ** 0.5)
