import numpy as np
import pytest
from scipy.special import voigt_profile

from labrun.reduction.peaks.merge import merged, significant
from labrun.reduction.peaks.voigt import Slit, fit_peaks

X = np.arange(250.0, 254.0, 0.034)
NET = 1_600.0 * voigt_profile(X - 251.61, 0.05, 0.02)
NOISE = np.sqrt(25.0 + 0.3 * NET)
SLIT = Slit(np.full(len(X), 0.05), 0.02)


def fitted(*places_nm):
    channels = np.searchsorted(X, places_nm)
    return channels, fit_peaks(X, NET, NOISE, channels, SLIT)


def test_two_profiles_that_share_a_line_become_one_with_its_area():
    channels, pair = fitted(251.60, 251.62)
    assert not significant(pair).any()  # each alone has any part of the light

    kept, peaks = merged(X, NET, NOISE, channels, np.array([80.0, 0.0]), pair, SLIT)

    assert kept.tolist() == channels[:1].tolist()
    assert peaks.area[0] == pytest.approx(1_600, rel=0.02)
    assert significant(peaks).all()


def test_lines_that_are_known_apart_stay():
    channels, pair = fitted(251.61, 252.9)

    assert len(merged(X, NET, NOISE, channels, np.array([80.0, 0.0]), pair, SLIT)[0]) == 2
