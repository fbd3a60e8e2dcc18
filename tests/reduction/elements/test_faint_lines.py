import numpy as np
import pytest

from labrun.reduction.elements.faint_lines import ENOUGH, explained
from labrun.reduction.plasma.strengths import atoms


def test_an_element_explains_its_own_faint_lines_and_nobody_elses(reduced):
    _, found = reduced("train", 0)
    identified, peaks = found.identified, found.peaks
    symbols = atoms().elements.tolist()
    lithium = symbols.index("Li")
    red = int(np.argmin(np.abs(peaks.centre_nm - identified.offsets.place(670.96))))
    by_others = explained(identified, peaks, np.array([red]), lithium)
    by_lithium = explained(identified, peaks, np.array([red]), symbols.index("Na"))

    assert by_others[0] < 0.1
    assert by_lithium[0] > ENOUGH


@pytest.mark.slow
@pytest.mark.parametrize("number", [0, 6])
def test_two_faint_lines_of_iron_are_no_chromium(number):
    from truth import everyday

    from labrun.reduction import Spectrum, reduce_spectrum

    truth = everyday("usual", number)
    found = reduce_spectrum(Spectrum(truth.wavelength_nm, truth.intensity))

    assert "Fe" in truth.present and "Fe" in found.detected
    assert "Cr" not in found.detected
