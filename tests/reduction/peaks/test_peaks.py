import numpy as np

from labrun.reduction.peaks.peaks import clear_of, find_peaks, standing_out
from labrun.reduction.spectrum.curve import softened


def test_every_strong_line_is_found_and_next_to_nothing_else(isolated):
    net = isolated.intensity - isolated.continuum
    channels = find_peaks(net, np.full(len(net), isolated.noise))
    distance_nm = np.abs(isolated.wavelength_nm[channels][:, None] - isolated.lines[:, 1])

    assert distance_nm.min(axis=0).max() < 0.1
    assert len(channels) <= len(isolated.lines) + 1


def test_noise_alone_has_no_more_than_a_stray_peak(make_truth):
    truth = make_truth([])
    net = truth.intensity - truth.continuum

    assert len(find_peaks(net, np.full(len(net), truth.noise))) <= 1


def test_an_empty_and_a_short_spectrum_have_no_peaks():
    assert len(find_peaks(np.zeros(0), np.zeros(0))) == 0
    assert len(find_peaks(np.ones(4), np.ones(4))) == 0


def test_how_clear_chosen_peaks_are_is_what_the_search_says_of_them(isolated):
    net, noise = isolated.intensity - isolated.continuum, np.full(len(isolated.intensity), 2.0)
    net[100:103] = 1e4  # a plateau
    soft = softened(net)
    tops, clear = standing_out(soft, noise, 1.0)
    beside = np.setdiff1d(tops + 1, tops)

    assert clear_of(soft, noise, tops).tolist() == clear.tolist() and 101 in tops
    assert not clear_of(soft, noise, beside).any()
    assert not clear_of(soft, noise, np.array([0])).any()
