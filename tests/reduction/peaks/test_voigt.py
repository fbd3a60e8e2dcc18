from dataclasses import replace

import numpy as np
import pytest
from scipy.special import voigt_profile

from labrun.reduction import Spectrum
from labrun.reduction.peaks.background import background
from labrun.reduction.peaks.voigt import fit_peaks, voigt


def fit_of(truth):
    """Fit every line of a known spectrum from the channel nearest to its centre."""
    net = truth.intensity - truth.continuum
    channels = np.searchsorted(truth.wavelength_nm, truth.lines[:, 1])
    return fit_peaks(truth.wavelength_nm, net, np.full(len(net), truth.noise), channels)


def test_the_profile_is_that_of_scipy():
    x = np.linspace(669, 673, 400)

    assert voigt(x, 5.0, 670.8, 0.06, 0.03) == pytest.approx(
        5.0 * voigt_profile(x - 670.8, 0.06, 0.03), rel=1e-7
    )


def test_areas_of_isolated_lines_are_right_to_three_percent(isolated):
    peaks = fit_of(isolated)
    wrong = np.abs(peaks.area / isolated.lines[:, 0] - 1)

    assert np.median(wrong) < 0.03
    assert peaks.settled.all()


def test_centres_are_right_to_a_tenth_of_a_channel(isolated):
    peaks = fit_of(isolated)

    assert np.median(np.abs(peaks.centre_nm - isolated.lines[:, 1])) < 0.0034


def test_errors_are_as_large_as_the_fit_says(isolated):
    # The background that subtraction leaves is part of the error, so it is estimated here.
    spectrum = Spectrum(isolated.wavelength_nm, isolated.intensity)
    peaks = fit_of(replace(isolated, continuum=background(spectrum)))
    pull = (peaks.area - isolated.lines[:, 0]) / peaks.area_error

    assert 0.6 < 1.4826 * np.median(np.abs(pull)) < 1.5
    assert np.median(peaks.chi2) == pytest.approx(1.0, abs=0.15)


def test_a_doublet_is_taken_apart(make_truth):
    truth = make_truth([(300.0, 500.0, 0.06, 0.02), (150.0, 500.3, 0.06, 0.02)], noise=2.0)
    peaks = fit_of(truth)

    assert peaks.area == pytest.approx(truth.lines[:, 0], rel=0.05)


def test_full_width_of_a_gaussian_and_of_a_lorentzian_are_known(make_truth):
    truth = make_truth([(900.0, 400.0, 0.08, 1e-6), (900.0, 600.0, 0.02, 0.1)], noise=1.0)
    gaussian, lorentzian = fit_of(truth).fwhm_nm

    assert gaussian == pytest.approx(0.08 * 2.3548, rel=0.03)
    assert lorentzian == pytest.approx(0.2, rel=0.06)


def test_no_peaks_give_an_empty_table():
    x = np.linspace(200, 300, 50)
    peaks = fit_peaks(x, np.zeros(50), np.ones(50), np.empty(0, dtype=np.int64))

    assert len(peaks) == 0 and peaks.covariance.shape == (0, 4, 4)


def test_a_spectrum_with_nan_is_refused():
    x = np.linspace(200, 300, 50)
    with pytest.raises(ValueError, match="bad channels"):
        fit_peaks(x, np.full(50, np.nan), np.ones(50), np.array([25]))
