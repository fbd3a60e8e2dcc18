import numpy as np
import pytest

from labrun.reduction.peaks.windows import groups, widths

X = np.arange(600.0)


def gaussian(centre, sigma, height=100.0):
    return height * np.exp(-0.5 * ((X - centre) / sigma) ** 2)


def test_the_width_of_a_gaussian_is_seen():
    assert widths(gaussian(300, 5), np.array([300])) == pytest.approx([5 * 2.355], rel=0.02)


def test_neighbours_share_a_group_and_strangers_do_not():
    y = gaussian(200, 4) + gaussian(215, 4) + gaussian(400, 4)
    peaks = np.array([200, 215, 400])
    found = groups(y, peaks, widths(y, peaks))

    assert found[:, :2].tolist() == [[0, 2], [2, 3]]


def test_channels_of_a_group_stay_inside_the_spectrum():
    y = gaussian(2, 4) + gaussian(597, 4)
    peaks = np.array([2, 597])
    found = groups(y, peaks, widths(y, peaks))

    assert found[0, 2] == 0 and found[-1, 3] == len(X)
