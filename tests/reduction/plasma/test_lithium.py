import numpy as np
import pytest

from labrun.reduction.plasma.lithium import ratio_curve, ratio_temperature


def test_the_curve_rises_with_temperature_and_is_read_backwards():
    kelvin = np.array([7_000.0, 9_000.0, 12_000.0])
    ratio = ratio_curve(kelvin)
    found = [ratio_temperature(1e3 * r, 10.0, 1e3, 10.0) for r in ratio.tolist()]

    assert np.all(np.diff(ratio) > 0)
    assert [f.temperature_k for f in found if f] == pytest.approx(kelvin.tolist(), rel=1e-6)


def test_the_ratio_is_boltzmanns_with_the_constants_of_nist():
    # 610.35 nm: 2p-3d, g A = 6*7.14e7 + 4*5.95e7*... summed as 10 * 7.0e7; 670.78: 6 * 3.69e7.
    by_hand = 10 * 7.0e7 / 610.5 / (6 * 3.69e7 / 671.0) * np.exp(-2.031 / (8.617e-5 * 10_000))

    assert ratio_curve(np.array([10_000.0]))[0] == pytest.approx(by_hand, rel=0.1)


def test_a_ratio_that_no_temperature_gives_is_none():
    assert ratio_temperature(1e6, 1.0, 1.0, 0.1) is None
    assert ratio_temperature(0.0, 1.0, 1.0, 0.1) is None


def test_errors_grow_with_those_of_the_areas():
    sure, unsure = (ratio_temperature(200.0, e, 1_000.0, e) for e in (1.0, 20.0))

    assert sure and unsure
    assert unsure.temperature_error_k > 10 * sure.temperature_error_k > 0
