"""What real instruments do: the benchmark prints the whole table."""

import pytest
from truth import with_vice

from labrun.reduction import Spectrum, reduce_spectrum

from .test_accuracy import scored

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(
    "vice",
    [
        *(
            pytest.param(one, marks=pytest.mark.soak)
            for one in ("steps of 20", "roll-off", "cut at zero", "blaze", "smoothed", "spikes")
        ),
        "handheld",
    ],
)
def test_the_elements_are_found_in_spite_of(vice):
    hits = wrong = missed = 0
    for number in (0, 1, 2):
        truth = with_vice(vice, number)
        said = scored(truth, reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity)))
        hits, wrong, missed = hits + said.hits, wrong + said.false_claims, missed + said.missed

    assert 2 * hits / (2 * hits + wrong + missed) > 0.88


def test_single_photons_of_an_intensified_camera_are_not_taken_for_lines():
    hits = wrong = 0
    for number in (0, 1, 2):
        truth = with_vice("photons", number)
        said = scored(truth, reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity)))
        hits, wrong = hits + said.hits, wrong + said.false_claims

    assert hits >= 14
    assert wrong <= 1
