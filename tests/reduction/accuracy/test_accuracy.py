"""The floors of accuracy, over spectra of a generator that shares no code with the package.

These are few spectra, and single ones weigh much; `benchmarks/reduce.py` prints the whole table.
"""

import numpy as np
import pytest
from truth import Score, line_free, pure_noise, score, summary

from labrun.reduction import Spectrum, reduce_spectrum

# One process makes what all of them look at.
pytestmark = pytest.mark.slow


FAMILIES = {
    "train": ("train", range(0, 33, 2)),
    "held out": ("held out", range(20)),
    "half of the held out": ("held out", range(0, 20, 2)),
}
FLOORS = {"peaks recall": 0.90, "peaks precision": 0.83, "elements F1": 0.92}
CEILINGS = {"area error": 0.05, "T error": 0.10}


def scored(truth, found):
    plasma, peaks = found.plasma, found.peaks
    kelvin = (plasma.temperature_k, plasma.temperature_error_k) if plasma else None
    return score(
        truth, peaks.centre_nm, peaks.covariance[:, 1, 1] ** 0.5, peaks.area, peaks.area_error,
        set(found.detected), kelvin if kelvin and kelvin[0] else None,
        plasma.log10_ne if plasma else None, found.medium,
    )  # fmt: skip


@pytest.fixture(
    scope="module",
    params=[
        "half of the held out",
        *(pytest.param(f, marks=pytest.mark.soak) for f in ("held out", "train")),
    ],
)
def table(request, reduced):
    total = Score()
    family, numbers = FAMILIES[request.param]
    for number in numbers:
        total.add(scored(*reduced(family, number)))
    return summary(total)


@pytest.mark.parametrize("name", FLOORS)
def test_what_is_there_is_found_and_what_is_found_is_there(table, name):
    assert table[name] >= FLOORS[name]


@pytest.mark.parametrize("name", CEILINGS)
def test_areas_and_temperatures_are_near_the_truth(table, name):
    assert table[name] <= CEILINGS[name]


def test_errors_are_as_large_as_they_say(table):
    assert 0.8 < table["area pull"] < 1.4
    assert 0.6 < table["centre pull"] < 1.4


@pytest.mark.parametrize("make", [pure_noise, line_free])
def test_no_element_is_claimed_where_there_is_none(make):
    claims = [reduce_spectrum(Spectrum(*make(number))).detected for number in range(25)]

    assert not any(claims)


def test_no_element_is_claimed_in_noise_that_neighbours_share():
    kernels = [np.ones(w) for w in (2, 3, 5, 8)] + [0.5 ** np.arange(12), 0.8 ** np.arange(40)]
    claims = []
    for number in range(24):
        rng = np.random.default_rng(number)
        kernel = kernels[number % len(kernels)]
        x = np.linspace(190.0, 961.0, (2_048, 8_192, 22_800)[number % 3])
        noise = np.convolve(rng.normal(0, 5, len(x) + len(kernel) - 1), kernel, "valid")
        claims += [reduce_spectrum(Spectrum(x, y)).detected for y in (300 + noise, noise.clip(0))]

    assert not any(claims)


def test_no_bright_peak_is_lost(reduced):
    """Two profiles once shared the lines of iron at 259.9 and 267.2 nm, and both were dropped."""
    truth, found = reduced("train", 8)
    bright = truth.maxima_nm[truth.maxima_sigma > 20]
    away = np.abs(found.peaks.centre_nm[:, None] - bright).min(axis=0)

    assert away.max() < max(0.05, 0.4 * truth.instrument.fwhm_nm.max())


def test_the_evidence_can_be_checked_on_the_spectrum(reduced):
    _, found = reduced("train", 0)
    lithium = found.evidence["Li"]

    assert lithium.status == "detected"
    assert 2 <= lithium.lines_matched <= lithium.lines_expected
    assert lithium.area > 10 * lithium.area_error
    assert abs(found.peaks.centre_nm - lithium.line_nm).min() < 0.05
    assert found.evidence["Tm"].status == "absent" and found.evidence["Tm"].detection_limit > 0


def test_the_medium_may_be_told(reduced):
    truth, found = reduced("train", 0)
    told = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity), medium="air")

    assert told.medium == found.medium == "air"
    assert told.detected == found.detected
