import numpy as np
import pytest

from labrun.reduction.lines.lines import lines_of, partition_function
from labrun.reduction.plasma.plasma import relative_strengths
from labrun.reduction.plasma.strengths import atoms, log_strengths


def rows_of(element):
    a = atoms()
    return np.flatnonzero(a.elements[a.element] == element)


@pytest.mark.parametrize("element", ["Li", "Fe", "Ca", "H"])
@pytest.mark.parametrize("kelvin", [8_000.0, 11_300.0, 14_000.0])
def test_all_at_once_is_as_one_by_one(element, kelvin):
    lines = lines_of(element)
    one_by_one = relative_strengths(lines, kelvin, 1e17)
    bright = one_by_one > 1e-6 * one_by_one.max()
    difference = (log_strengths(rows_of(element), kelvin, 1e17) - np.log(one_by_one))[bright]

    assert np.ptp(difference) < 0.02


def test_the_sums_over_states_are_read_between_the_grid_points():
    a = atoms()
    iron = a.elements.tolist().index("Fe")
    between = np.interp(9_000.0, np.arange(4_000.0, 20_001.0, 400.0), a.log_u[iron, 0])

    assert np.exp(between) == pytest.approx(partition_function("Fe", 1, 9_000.0), rel=2e-3)


def test_guessed_widths_are_of_the_size_of_known_ones():
    from labrun.reduction.lines.lines import line_table
    from labrun.reduction.plasma.strengths import _guessed_width

    a = atoms()
    known = line_table().stark_fwhm_nm(10_000.0, 1e17)
    both = np.isfinite(known) & (known > 0)
    ratio = np.log(_guessed_width(a.elements, a.element)[both] / known[both])

    assert abs(np.median(ratio)) < 1.0
