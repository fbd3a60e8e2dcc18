import numpy as np
import pytest

from labrun.reduction.spectrum.noise import cut_off, local_noise


def test_the_noise_is_found_under_lines_and_continuum(isolated):
    noise = local_noise(isolated.intensity)

    assert np.median(noise) == pytest.approx(isolated.noise, rel=0.1)


def test_noise_that_grows_along_the_spectrum_is_followed():
    rng = np.random.default_rng(1)
    truth = np.linspace(1, 10, 8_000)
    noise = local_noise(rng.normal(0, truth))

    assert np.median(np.abs(noise / truth - 1)) < 0.1


@pytest.mark.parametrize("n", [1, 2, 3, 50])
def test_a_flat_spectrum_of_any_length_has_a_noise_above_zero(n):
    noise = local_noise(np.zeros(n))

    assert noise.shape == (n,) and np.all(noise > 0)


def test_an_export_that_is_cut_at_zero_is_not_noiseless():
    rng = np.random.default_rng(3)
    counts = np.maximum(rng.normal(-2.0, 5.0, 8_000), 0.0)
    counts[3_000:3_700] = 0.0  # a stretch with nothing else
    noise = local_noise(counts)

    assert cut_off(counts).mean() > 0.5
    assert noise.min() > 2.5 and noise.max() < 7.0


def test_counts_that_are_seldom_equal_are_not_cut():
    rng = np.random.default_rng(3)

    assert not cut_off(rng.normal(100.0, 5.0, 8_000)).any()
    assert not cut_off(np.round(rng.normal(100.0, 5.0, 8_000))).any()


def test_rounded_counts_have_the_noise_of_rounding():
    rng = np.random.default_rng(3)
    noise = local_noise(np.round(rng.normal(np.linspace(1_000.0, 1_500.0, 8_000), 1.0), -1))

    assert noise.min() > 3.0  # of steps of 10
