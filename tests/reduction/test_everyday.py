"""Everyday instruments, one trouble each: the benchmark prints the whole table."""

import numpy as np
import pytest
from test_accuracy import scored
from truth import KINDS, everyday

from labrun.reduction import Spectrum, reduce_spectrum


@pytest.mark.parametrize("kind", KINDS)
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
