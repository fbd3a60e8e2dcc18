import numpy as np
import pytest

from labrun.reduction import Spectrum
from labrun.reduction.peaks.profiles import fit_profiles
from labrun.reduction.peaks.render import render


def test_a_hidden_line_is_found_in_the_residual(make_truth):
    lines = [(400.0, 250.0 + 12 * k, 0.06, 0.02) for k in range(30)]
    truth = make_truth([*lines, (120.0, 430.15, 0.06, 0.02)], noise=2.0)
    profiles = fit_profiles(Spectrum(truth.wavelength_nm, truth.intensity))
    near = np.abs(profiles.peaks.centre_nm - 430.15)

    assert near.min() < 0.03
    assert profiles.peaks.area[np.argmin(near)] == pytest.approx(120, rel=0.15)


def test_what_is_drawn_is_what_was_fitted(isolated):
    profiles = fit_profiles(Spectrum(isolated.wavelength_nm, isolated.intensity))
    model = render(isolated.wavelength_nm, profiles.peaks, 0.05 * profiles.noise)
    left = (profiles.net - model) / profiles.noise

    assert 0.9 < 1.4826 * np.median(np.abs(left)) < 1.1


def test_peaks_ascend(isolated):
    centre_nm = fit_profiles(Spectrum(isolated.wavelength_nm, isolated.intensity)).peaks.centre_nm

    assert np.all(np.diff(centre_nm) > 0)


def test_a_bad_channel_on_a_line_has_no_say(make_truth):
    truth = make_truth([(800.0, 670.781, 0.06, 0.03)])
    top = int(np.searchsorted(truth.wavelength_nm, 670.781))
    bad = np.zeros(len(truth.intensity), dtype=bool)
    bad[top + 1] = True
    truth.intensity[top + 1] = 0.0
    peaks = fit_profiles(Spectrum(truth.wavelength_nm, truth.intensity), bad).peaks

    assert peaks.area.max() == pytest.approx(800, rel=0.05)


def test_the_gain_of_the_detector_is_learnt():
    from truth import make_spectrum

    truth = make_spectrum("train", 6)
    profiles = fit_profiles(Spectrum(truth.wavelength_nm, truth.intensity))
    gain = truth.instrument.gain / truth.instrument.averaged

    assert 0.3 * gain < profiles.gain < 3 * gain
    assert np.median(profiles.noise / truth.noise) == pytest.approx(1.0, abs=0.1)


def shared_noise(kernel, channels=8_192, seed=1):
    rng = np.random.default_rng(seed)
    kernel = np.asarray(kernel) / np.linalg.norm(kernel)
    noise = np.convolve(rng.normal(0, 5, channels + len(kernel) - 1), kernel, "valid")
    return Spectrum(np.linspace(200.0, 900.0, channels), 300 + noise)


@pytest.mark.parametrize(
    "kernel", [np.ones(2), np.ones(5), np.ones(8), 0.5 ** np.arange(12), 0.8 ** np.arange(40)]
)
def test_noise_that_neighbours_share_has_no_peaks(kernel):
    """There were 450 of them, and iron, cerium and a dozen more were said to be there."""
    assert len(fit_profiles(shared_noise(kernel)).peaks) < 5


def test_waves_of_the_continuum_are_followed_and_lines_on_them_found():
    rng = np.random.default_rng(2)
    x = np.linspace(300.0, 700.0, 8_000)
    counts = 400 * (1 - 0.75 * np.cos(np.pi * x / 12.0) ** 2) + rng.normal(0, 4, len(x))
    places = 305.0 + 13.0 * np.arange(30)
    for place in places:
        counts += 300 * np.exp(-0.5 * ((x - place) / 0.06) ** 2)
    peaks = fit_profiles(Spectrum(x, counts)).peaks
    away = np.abs(peaks.centre_nm[:, None] - places)

    assert away.min(axis=0).max() < 0.05
    assert np.mean(away.min(axis=1) < 0.05) > 0.9
