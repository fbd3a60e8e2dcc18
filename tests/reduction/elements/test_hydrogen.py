import numpy as np
import pytest
from scipy.special import voigt_profile

from labrun.reduction.elements.hydrogen import h_alpha
from labrun.reduction.elements.offsets import Offsets
from labrun.reduction.peaks.profiles import fit_profiles
from labrun.reduction.spectrum.spectrum import Spectrum

X = np.linspace(600, 720, 4_000)


def with_h_alpha(log_ne, area=3_000.0, seed=1):
    rng = np.random.default_rng(seed)
    gamma = 0.5 * 1.098 * 10 ** ((log_ne - 17) / 1.47135)
    counts = 300 + X - 600 + area * voigt_profile(X - 656.28, 0.06, gamma)
    counts += 400 * voigt_profile(X - 670.78, 0.05, 0.02)
    counts += 400 * voigt_profile(X - 634.71, 0.05, 0.02)
    counts += 300 * voigt_profile(X - 610.36, 0.05, 0.02) + 300 * voigt_profile(X - 690, 0.05, 0.02)
    return Spectrum(X, counts + rng.normal(0, 6, len(X)))


@pytest.mark.parametrize("log_ne", [16.4, 16.8, 17.2])
def test_the_density_is_that_of_the_width(log_ne):
    profiles = fit_profiles(with_h_alpha(log_ne))
    found = h_alpha(X, profiles.counts, profiles, Offsets.none("air"))

    assert found is not None
    assert found.log10_ne == pytest.approx(log_ne, abs=0.12)
    assert found.log10_ne_error > 0.05


def test_no_hydrogen_gives_no_density():
    profiles = fit_profiles(with_h_alpha(17.0, area=0.0))

    assert h_alpha(X, profiles.counts, profiles, Offsets.none("air")) is None


def test_a_spectrum_that_ends_before_it_gives_none():
    short = slice(0, 1_500)
    spectrum = with_h_alpha(17.0)
    profiles = fit_profiles(Spectrum(X[short], spectrum.intensity[short]))

    assert h_alpha(X[short], profiles.counts, profiles, Offsets.none("air")) is None
