import numpy as np
import pytest

from labrun.reduction.peaks.snip import clip_peaks


def test_a_straight_line_stays_as_it_is():
    line = np.linspace(1_000, 1_001, 500)

    assert clip_peaks(line, 20) == pytest.approx(line, rel=1e-5)


def test_a_peak_narrower_than_the_window_goes():
    x = np.arange(500.0)
    peak = 900 * np.exp(-0.5 * ((x - 250) / 4) ** 2)

    assert clip_peaks(100 + peak, 40)[250] == pytest.approx(100, rel=0.1)


def test_a_hump_much_wider_than_the_window_stays():
    x = np.arange(4_000.0)
    hump = 900 * np.exp(-0.5 * ((x - 2_000) / 600) ** 2)

    assert clip_peaks(100 + hump, 40)[2_000] == pytest.approx(1_000, rel=0.05)
