import numpy as np
import pytest

from labrun.reduction.spectrum.noise import local_noise


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
