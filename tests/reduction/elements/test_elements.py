import numpy as np
import pytest

from labrun.reduction.elements.elements import (
    SAME_LINE_NM,
    UNRESOLVED_NM,
    predominant_line,
)
from labrun.reduction.lines.air import to_air
from labrun.reduction.lines.lines import lines_of
from labrun.reduction.lines.usual import USUAL_LINES


@pytest.mark.parametrize("element", USUAL_LINES)
def test_every_usual_line_is_a_line_of_the_table(element):
    stage, air_nm = USUAL_LINES[element]
    lines = lines_of(element)
    near = np.abs(to_air(lines.wavelength_nm) - air_nm) < SAME_LINE_NM

    assert stage in lines.stage[near]
    assert to_air(predominant_line(element).wavelength_nm) == pytest.approx(
        air_nm, abs=UNRESOLVED_NM
    )


def test_the_lithium_doublet_is_expected_between_its_members():
    assert predominant_line("Li").wavelength_nm == pytest.approx(670.966, abs=0.002)


def test_an_element_without_a_usual_line_takes_its_strongest():
    assert predominant_line("Pb").stage == 2
    assert 200 < predominant_line("Pb").wavelength_nm < 961
