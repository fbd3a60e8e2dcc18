"""Single photons of an intensified camera are no lines; lines behind one are found."""

import numpy as np

from labrun.reduction.peaks.peaks import find_peaks
from labrun.reduction.peaks.spikes import has_spikes
from labrun.reduction.spectrum.noise import local_noise


def drawn(rng, n, centres, sigma):
    heights = 300 * np.exp(rng.uniform(0, 4, len(centres)))
    return sum(
        h * np.exp(-0.5 * ((n - c) / sigma) ** 2) for h, c in zip(heights, centres, strict=True)
    )


def test_photons_are_spikes_and_lines_are_not():
    rng = np.random.default_rng(2)
    n = np.arange(20_000)
    centres = rng.uniform(50, 19_950, 200)
    lines = sum(3_000 * np.exp(-0.5 * ((n - centre) / 1.2) ** 2) for centre in centres)
    photons = np.convolve(
        300 * rng.gamma(rng.poisson(0.05, len(n)) + 1e-9), [0.15, 0.7, 0.15], "same"
    )
    read = rng.normal(0, 5, len(n))

    for counts, spiky in (
        (lines + read, False),
        (photons + read, True),
        (lines + photons + read, True),
        (drawn(rng, n, centres, 0.7) + read, False),  # a slit of 1.6 channels
    ):
        net = counts - np.median(counts)
        assert has_spikes(net, find_peaks(net, local_noise(net))) == spiky
