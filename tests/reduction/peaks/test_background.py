import numpy as np
import pytest

from labrun.reduction import Spectrum
from labrun.reduction.peaks.background import background, despike
from labrun.reduction.spectrum.noise import local_noise


def test_the_continuum_is_found_under_the_lines(isolated):
    found = background(Spectrum(isolated.wavelength_nm, isolated.intensity))

    assert np.median(np.abs(found - isolated.continuum)) < isolated.noise


def test_quiet_channels_scatter_around_zero_after_subtraction(make_truth):
    truth = make_truth([])
    net = truth.intensity - background(Spectrum(truth.wavelength_nm, truth.intensity))

    assert np.median(net) == pytest.approx(0, abs=truth.noise / 10)


def test_a_cosmic_ray_goes_and_a_line_stays(make_truth):
    truth = make_truth([(500.0, 670.78, 0.06, 0.02)])
    struck = truth.intensity.copy()
    struck[5_000] += 3_000
    calm = despike(struck, local_noise(struck))

    assert np.flatnonzero(calm != struck).tolist() == [5_000]


@pytest.mark.parametrize("n", [1, 4, 9, 30])
def test_a_short_spectrum_has_a_background_too(n):
    flat = Spectrum(np.arange(n) + 200.0, np.full(n, 7.0))

    assert background(flat) == pytest.approx(np.full(n, 7.0), rel=1e-6)
