from dataclasses import replace

import numpy as np
import pytest

from labrun.reduction.plasma.boltzmann import Known, fit_plot
from labrun.reduction.plasma.lithium_share import lithium_share, share_curve
from labrun.reduction.plasma.plot_fit import COOLEST_K
from labrun.reduction.plasma.strengths import atoms
from labrun.reduction.tables.plot import cation_fraction

from .uniform_plasma import lines_at


def plot_with_lithium(share, kelvin=10_000.0, log_ne=17.0):
    """Lines of Li and Si, so many atoms of lithium among them; no line absorbs itself."""
    both = lines_at(kelvin, log_ne, noise=0.01, elements=("Li", "Si"))
    is_li = atoms().elements[both.element] == "Li"
    area = both.log_area + np.where(is_li, np.log(share), np.log(1 - share))
    lines = type(both)(area, *(getattr(both, name) for name in type(both).__slots__[1:]))
    return lines, fit_plot(lines, Known(log_ne * np.log(10), 0.1))


@pytest.mark.parametrize("share", [0.01, 0.1, 0.5, 0.95])
def test_the_share_of_lithium_is_what_was_put_in(share):
    found = lithium_share(*plot_with_lithium(share))

    assert found.share == pytest.approx(share, rel=0.25)
    assert 0 < found.low < found.share < found.high < 1
    below, above = found.share - found.low, found.high - found.share
    assert (below < above) == (found.share < 0.5)  # the nearer bound is the nearer limit's
    assert abs(found.share - share) < 4 * found.share_error
    assert found.elements == ("Li", "Si")


def test_the_share_against_temperature_goes_through_that_of_the_plasma():
    lines, plot = plot_with_lithium(0.1)
    kelvin, share, low, high = share_curve(lines, plot)

    assert np.interp(plot.temperature_k, kelvin, share) == pytest.approx(
        lithium_share(lines, plot).share
    )
    assert np.all((low > 0) & (low < high) & (high < 1))
    assert np.ptp(share) > 0


def test_no_lithium_has_no_share():
    lines = lines_at(10_000.0, 17.0)

    assert lithium_share(lines, fit_plot(lines)) is None


def test_a_temperature_at_the_bound_of_the_fit_tells_no_share():
    lines, plot = plot_with_lithium(0.1)

    assert lithium_share(lines, replace(plot, temperature_k=COOLEST_K)) is None


def test_the_share_in_spodumene_is_near_that_of_its_formula(reduced):
    _, found = reduced("train", 0)
    share = cation_fraction(found)

    assert share.share == pytest.approx(0.25, abs=0.1)  # LiAlSi2O6: 1 of 4 cations
    assert 0 < share.share_error < 0.15
