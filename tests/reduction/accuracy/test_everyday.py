"""Everyday instruments, one trouble each: the benchmark prints the whole table."""

import numpy as np
import pytest
from truth import KINDS, everyday

from labrun.reduction import Spectrum, reduce_spectrum

from .test_accuracy import scored


@pytest.mark.parametrize(
    "kind",
    [
        kind if number % 4 == 0 else pytest.param(kind, marks=pytest.mark.slow)
        for number, kind in enumerate(KINDS)
    ],
)
def test_an_everyday_instrument_shows_what_is_there(kind):
    truth = everyday(kind, 2)
    found = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity))
    said = scored(truth, found)

    assert 2 * said.hits / (2 * said.hits + said.false_claims + said.missed) > 0.9
    assert np.median(said.area_error) < 0.09 and np.median(np.abs(said.pull)) < 1.5
    assert np.median(np.abs(said.kelvin_error)) < 0.12
    assert said.recalled > 0.7 * said.true_peaks
    # Where channels are averaged, peaks are found that no single channel shows: those count right.
    assert found.averaged > 1 or said.right > 0.6 * said.found_peaks


@pytest.mark.parametrize("span_nm", [(190.0, 193.3), (120.0, 125.0), (980.0, 1020.0)])
def test_a_window_that_the_line_table_knows_nothing_of_names_no_element(span_nm):
    nm = np.linspace(*span_nm, 400)
    counts = 100 + np.random.default_rng(5).standard_normal(400)
    counts += 500 * np.exp(-0.5 * ((nm - nm[200]) / (4 * (nm[1] - nm[0]))) ** 2)
    found = reduce_spectrum(Spectrum(nm, counts))

    assert len(found.peaks) >= 1
    assert found.detected == []
