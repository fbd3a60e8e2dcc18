import numpy as np
import pytest

from labrun.reduction.lines.lines import line_table, lines_of
from labrun.reduction.plasma.plasma import relative_strengths, saha_ratio


def test_lithium_is_mostly_ionised_at_one_electronvolt_and_hydrogen_is_not():
    assert saha_ratio("Li", 11_600.0, 1e17) > 5
    assert saha_ratio("H", 11_600.0, 1e17) < 0.5


def test_more_electrons_mean_fewer_ions():
    assert saha_ratio("Ca", 10_000.0, 1e16) == pytest.approx(10 * saha_ratio("Ca", 10_000.0, 1e17))


def test_the_red_line_of_lithium_is_stronger_than_the_orange_one():
    lines = lines_of("Li")
    strengths = relative_strengths(lines)
    red, orange = (np.argmin(np.abs(lines.wavelength_nm - nm)) for nm in (670.961, 610.533))

    assert strengths[red] > strengths[orange] > 0


def test_lines_of_two_elements_at_once_are_refused():
    with pytest.raises(ValueError, match="one element"):
        relative_strengths(line_table())
