import numpy as np
import pytest

from labrun.reduction import Spectrum
from labrun.reduction.peaks.pitch import fit_at_pitch, narrow_channels
from labrun.reduction.spectrum.bad import mark_bad
from labrun.reduction.spectrum.resampled import resampled, sharing


def spectrum(n, seed=1):
    """White noise on a slope with some lines."""
    rng = np.random.default_rng(seed)
    t = np.linspace(0, 1, n)
    lines = sum(900 * np.exp(-0.5 * ((t - c) / 2e-4) ** 2) for c in rng.uniform(0, 1, 40))
    return 300 + 100 * t + lines + rng.normal(0, 5, n)


@pytest.mark.parametrize("n", [2_048, 6_000, 22_800])
def test_white_noise_shares_nothing(n):
    assert [resampled(spectrum(n, seed)) for seed in range(8)] == [1] * 8


@pytest.mark.parametrize(("detector", "channels"), [(6_144, 4), (8_192, 3), (12_288, 2)])
def test_an_interpolated_export_is_told_with_how_many_channels_share(detector, channels):
    own = spectrum(detector)
    export = np.interp(np.linspace(0, 1, 22_800), np.linspace(0, 1, detector), own)

    assert abs(resampled(export) - channels) <= 1


def test_a_smooth_interpolation_is_told_as_well():
    from scipy.interpolate import CubicSpline

    export = CubicSpline(np.linspace(0, 1, 8_192), spectrum(8_192))(np.linspace(0, 1, 22_800))

    assert resampled(export) > 1


def test_a_short_or_flat_spectrum_shares_nothing():
    assert sharing(np.ones(50)) == 0.0
    assert resampled(np.ones(5_000)) == 1


def test_what_neighbours_still_share_does_not_make_peaks_of_noise():
    x, own = np.linspace(200, 900, 22_800), np.random.default_rng(2).normal(300, 5, 8_192)
    export = np.interp(x, np.linspace(200, 900, 8_192), own)
    bad = mark_bad(export, alone=False)
    profiles, channels = fit_at_pitch(Spectrum(x, export), bad, shared=resampled(export))
    seen = np.std(profiles.counts)

    assert channels == 3 and len(profiles.peaks) <= 3
    assert np.median(profiles.noise) == pytest.approx(seen, rel=0.15)


def test_a_smoothed_export_is_not_averaged_over_its_lines():
    rng, n = np.random.default_rng(3), 6_144
    t = np.arange(n)
    lines = sum(
        a * np.exp(-0.5 * ((t - c) / 1.6) ** 2)
        for c, a in zip(rng.uniform(20, n - 20, 300), 10 ** rng.uniform(2, 4, 300), strict=True)
    )
    smooth = np.convolve(rng.normal(0, 12, n + 30), np.hanning(17) / 8, "same")[15:-15]
    export = 500 + lines + smooth
    bad = mark_bad(export, alone=False)
    shared = resampled(export)
    profiles, channels = fit_at_pitch(Spectrum(240 + 0.1 * t, export), bad, shared=shared)

    assert shared > 2 and narrow_channels(export, bad.any) == pytest.approx(3.8, rel=0.15)
    assert channels == 1 and len(profiles.peaks) > 120


def test_photons_as_wide_as_lines_are_not_taken_for_lines():
    """An intensifier blurs both alike; there were 870 peaks for 40 lines."""
    rng, t = np.random.default_rng(5), np.arange(16_000)
    places = np.linspace(100, 15_900, 40)
    light = 0.3 + 0.24 * np.cos(t / 2_000)
    light += sum(12 * np.exp(-0.5 * ((t - place) / 1.5) ** 2) for place in places)
    photons = 300 * rng.gamma(rng.poisson(light) + 1e-9) + rng.normal(0, 30, len(t))
    blur = np.exp(-0.5 * (np.arange(-8, 9) / 2.0) ** 2)
    export = np.convolve(photons, blur / blur.sum(), "same")
    bad = mark_bad(export, alone=False)
    x, shared = 300 + 0.01 * t, resampled(export)
    profiles, channels = fit_at_pitch(Spectrum(x, export), bad, shared=shared)
    away = np.abs(profiles.peaks.centre_nm[:, None] - (300 + 0.01 * places))

    assert shared > 2 and channels == 1
    assert away.min(axis=0).max() < 0.02 and len(profiles.peaks) < 150
