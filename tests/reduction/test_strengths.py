import numpy as np
import pytest

from labrun.reduction.lines import lines_of, partition_function
from labrun.reduction.plasma import relative_strengths, saha_ratio
from labrun.reduction.strengths import atoms, ion_share, log_slopes, log_strengths


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


def test_the_share_of_ions_is_sahas():
    calcium = atoms().elements.tolist().index("Ca")
    ratio = saha_ratio("Ca", 10_000.0, 1e17)

    assert ion_share(10_000.0, 1e17)[calcium] == pytest.approx(ratio / (1 + ratio), rel=1e-3)


def test_slopes_are_the_limits_of_differences():
    a, rows = atoms(), rows_of("Mg")
    heat, density = log_slopes(a.element[rows], a.ion[rows], a.e_k_ev[rows], 10_000.0, 1e17)
    by_heat = log_strengths(rows, 10_050.0, 1e17) - log_strengths(rows, 9_950.0, 1e17)
    by_density = log_strengths(rows, 1e4, 1.05e17) - log_strengths(rows, 1e4, 0.95e17)

    assert np.allclose(heat, by_heat / np.log(10_050 / 9_950), atol=0.05)
    assert np.allclose(density, by_density / np.log(1.05 / 0.95), atol=0.01)


def test_the_sums_over_states_are_read_between_the_grid_points():
    a = atoms()
    iron = a.elements.tolist().index("Fe")
    between = np.interp(9_000.0, np.arange(4_000.0, 20_001.0, 400.0), a.log_u[iron, 0])

    assert np.exp(between) == pytest.approx(partition_function("Fe", 1, 9_000.0), rel=2e-3)


def test_guessed_widths_are_of_the_size_of_known_ones():
    from labrun.reduction.lines import line_table
    from labrun.reduction.strengths import _guessed_width

    a = atoms()
    known = line_table().stark_fwhm_nm(10_000.0, 1e17)
    both = np.isfinite(known) & (known > 0)
    ratio = np.log(_guessed_width(a.elements, a.element)[both] / known[both])

    assert abs(np.median(ratio)) < 1.0
