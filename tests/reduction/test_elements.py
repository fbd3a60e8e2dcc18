import numpy as np
import pytest

from labrun.reduction.air import to_air
from labrun.reduction.elements import (
    SAME_LINE_NM,
    UNRESOLVED_NM,
    USUAL_LINES,
    expected_nm,
    near_lines,
    predominant_line,
)
from labrun.reduction.lines import lines_of


@pytest.mark.parametrize("element", USUAL_LINES)
def test_every_usual_line_is_a_line_of_the_table(element):
    stage, air_nm = USUAL_LINES[element]
    lines = lines_of(element)
    near = np.abs(to_air(lines.wavelength_nm) - air_nm) < SAME_LINE_NM

    assert stage in lines.stage[near]
    assert expected_nm([element])[0] == pytest.approx(air_nm, abs=UNRESOLVED_NM)


def test_the_lithium_doublet_is_expected_between_its_members():
    assert expected_nm(["Li"])[0] == pytest.approx(670.781, abs=0.002)
    assert expected_nm(["Li"], "vacuum")[0] == pytest.approx(670.966, abs=0.002)


def test_an_element_without_a_usual_line_takes_its_strongest():
    assert predominant_line("Pb").stage == 2
    assert 200 < predominant_line("Pb").wavelength_nm < 961


def test_only_channels_near_a_line_are_chosen():
    assert near_lines(np.array([500.0, 670.9, 672.0]), np.array([670.78])).tolist() == [1]
    assert near_lines(np.array([500.0]), np.array([])).tolist() == []
