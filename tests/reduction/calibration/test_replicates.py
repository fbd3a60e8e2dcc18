"""Scatter and outliers of shots, on draws whose scatter is known."""

import numpy as np
import pytest

from labrun.reduction.calibration.replicates import outliers, shot_scatter


def drawn(rng, n=6, floor=5.0, part=0.1):
    means = (0.0, 30.0, 100.0, 300.0, 1000.0, 2000.0, 3000.0, 4000.0)
    return [m * (1 + part * rng.standard_normal(n)) + floor * rng.standard_normal(n) for m in means]


def noise(signals, floor=5.0):
    return [np.full(len(one), floor) for one in signals]


def test_the_floor_and_the_part_of_the_scatter_are_found():
    rng = np.random.default_rng(1)
    found = [shot_scatter(s, noise(s, 1.0)) for s in (drawn(rng) for _ in range(50))]
    floor, part = np.mean(found, axis=0)

    assert floor == pytest.approx(5.0, rel=0.2)
    assert part == pytest.approx(0.1, rel=0.1)


def test_single_shots_tell_the_noise_alone():
    assert shot_scatter([np.array([5.0]), np.array([9.0])], noise([[1], [1]], 3.0)) == (3.0, 0.0)


def test_a_shot_that_missed_is_found_and_hardly_any_other():
    rng = np.random.default_rng(2)
    seen = wrong = 0
    for _ in range(40):
        signals = drawn(rng)
        signals[5][2] *= 0.2
        far = outliers(signals, noise(signals))
        seen += far[5][2]
        wrong += sum(int(one.sum()) for one in far) - far[5][2]

    assert seen >= 36
    assert wrong <= 0.01 * 40 * 48


def test_a_standard_that_comes_in_two_halves_scatters_and_has_no_outliers():
    signals = [np.array([10.0, 10.0, 90.0, 90.0]), *(np.full(4, 100.0 + k) for k in range(5))]

    assert not any(one.any() for one in outliers(signals, noise(signals, 1.0)))


def test_three_shots_tell_no_outlier():
    signals = [np.array([100.0, 101.0, 900.0]), np.array([10.0, 10.0, 11.0])]

    assert not any(one.any() for one in outliers(signals, noise(signals, 1.0)))
