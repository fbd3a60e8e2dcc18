import numpy as np
import pytest

from labrun.reduction import Spectrum


def test_bad_channels_are_bridged_by_a_straight_line():
    spectrum = Spectrum(np.array([1.0, 2.0, 4.0]), np.array([10.0, np.nan, 40.0]))

    assert spectrum.without_bad().intensity.tolist() == [10.0, 20.0, 40.0]


@pytest.mark.parametrize(
    ("wavelength_nm", "intensity", "sentence"),
    [
        ([1.0, 2.0], [1.0], "same length"),
        ([], [], "at least one channel"),
        ([2.0, 1.0], [1.0, 1.0], "ascend"),
    ],
)
def test_arrays_that_are_no_spectrum_are_refused(wavelength_nm, intensity, sentence):
    with pytest.raises(ValueError, match=sentence):
        Spectrum(np.array(wavelength_nm), np.array(intensity))


def test_a_spectrum_of_bad_channels_only_is_refused():
    with pytest.raises(ValueError, match="every channel"):
        Spectrum(np.array([1.0]), np.array([np.nan])).without_bad()
