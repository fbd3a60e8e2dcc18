"""Spectra with a known truth, made without any code of the package under test."""

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from scipy.special import voigt_profile

sys.path.insert(0, str(Path(__file__).parent))  # for `truth`, which the benchmark reads as well

CHANNELS = 22_800
FIRST_NM, LAST_NM = 190.0, 961.0


@dataclass(frozen=True)
class Truth:
    """A spectrum and what it was made of: one row (area, centre, sigma, gamma) a line."""

    wavelength_nm: np.ndarray
    intensity: np.ndarray
    continuum: np.ndarray
    lines: np.ndarray
    noise: float


@pytest.fixture
def make_truth():
    def make(lines, noise=5.0, seed=0, channels=CHANNELS):
        rng = np.random.default_rng(seed)
        wavelength_nm = np.linspace(FIRST_NM, LAST_NM, channels)
        continuum = 300 + 200 * np.exp(-(((wavelength_nm - 450) / 150) ** 2))
        intensity = continuum + rng.normal(0, noise, channels)
        for area, centre, sigma, gamma in lines:
            intensity += area * voigt_profile(wavelength_nm - centre, sigma, gamma)
        return Truth(wavelength_nm, intensity, continuum, np.array(lines), noise)

    return make


@pytest.fixture
def isolated(make_truth):
    """A hundred lines that keep 5 nm from each other, strong enough to be measured to a percent."""
    rng = np.random.default_rng(7)
    n = 100
    centre = np.linspace(200, 950, n) + rng.uniform(-1, 1, n)
    area = 10 ** rng.uniform(2.0, 3.5, n)
    sigma, gamma = rng.uniform(0.04, 0.08, n), rng.uniform(0.01, 0.06, n)
    return make_truth(np.column_stack([area, centre, sigma, gamma]))


@pytest.fixture(scope="session")
def reduced():
    """A pair of truth and reduction by family and number, each made once."""
    from functools import cache

    from truth import make_spectrum

    from labrun.reduction import Spectrum, reduce_spectrum

    @cache
    def of(family, number):
        truth = make_spectrum(family, number)
        return truth, reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity))

    return of
