import numpy as np
import pytest
from test_boltzmann import lines_at

from labrun.reduction.boltzmann import Known, fit_plot
from labrun.reduction.lithium import (
    lithium_fraction,
    lithium_fraction_curve,
    ratio_curve,
    ratio_temperature,
    shine,
)
from labrun.reduction.strengths import atoms


def test_the_curve_rises_with_temperature_and_is_read_backwards():
    kelvin = np.array([7_000.0, 9_000.0, 12_000.0])
    ratio = ratio_curve(kelvin)
    found = [ratio_temperature(1e3 * r, 10.0, 1e3, 10.0) for r in ratio.tolist()]

    assert np.all(np.diff(ratio) > 0)
    assert [f.temperature_k for f in found if f] == pytest.approx(kelvin.tolist(), rel=1e-6)


def test_the_ratio_is_boltzmanns_with_the_constants_of_nist():
    # 610.35 nm: 2p-3d, g A = 6*7.14e7 + 4*5.95e7*... summed as 10 * 7.0e7; 670.78: 6 * 3.69e7.
    by_hand = 10 * 7.0e7 / 610.5 / (6 * 3.69e7 / 671.0) * np.exp(-2.031 / (8.617e-5 * 10_000))

    assert ratio_curve(np.array([10_000.0]))[0] == pytest.approx(by_hand, rel=0.1)


def test_a_ratio_that_no_temperature_gives_is_none():
    assert ratio_temperature(1e6, 1.0, 1.0, 0.1) is None
    assert ratio_temperature(0.0, 1.0, 1.0, 0.1) is None


def test_errors_grow_with_those_of_the_areas():
    sure, unsure = (ratio_temperature(200.0, e, 1_000.0, e) for e in (1.0, 20.0))

    assert sure and unsure
    assert unsure.temperature_error_k > 10 * sure.temperature_error_k > 0


def test_a_hotter_plasma_needs_more_lithium_for_the_same_light():
    amount = lithium_fraction(np.array([9_000.0, 12_000.0]), 1e17, 100.0)

    assert amount[1] > amount[0]
    assert amount[0] == pytest.approx(100.0 / shine(9_000.0, 1e17))
    assert 0 < lithium_fraction(np.array([9_000.0]), 1e17, 100.0, others=amount[0])[0] == 0.5


def plot_with_lithium(share, kelvin=10_000.0, log_ne=17.0):
    """Lines of Li and Si, so many atoms of lithium among them; no line absorbs itself."""
    both = lines_at(kelvin, log_ne, noise=0.01, elements=("Li", "Si"))
    is_li = atoms().elements[both.element] == "Li"
    area = both.log_area + np.where(is_li, np.log(share), np.log(1 - share))
    lines = type(both)(area, *(getattr(both, name) for name in type(both).__slots__[1:]))
    return lines, fit_plot(lines, Known(log_ne * np.log(10), 0.1))


@pytest.mark.parametrize("share", [0.01, 0.1, 0.5])
def test_the_fraction_of_lithium_is_what_was_put_in(share):
    found = lithium_fraction_curve(*plot_with_lithium(share))

    assert found.at_plasma == pytest.approx(share, rel=0.25)
    assert abs(found.at_plasma - share) < 4 * found.at_plasma_error


def test_the_fraction_against_temperature_goes_through_that_of_the_plasma():
    lines, plot = plot_with_lithium(0.1)
    near = np.array([0.9, 1.0, 1.1]) * plot.temperature_k
    found = lithium_fraction_curve(lines, plot, near)

    assert found.fraction[1] == pytest.approx(found.at_plasma)
    assert len(set(found.fraction.tolist())) == 3 and np.all(
        (found.fraction > 0) & (found.fraction < 1)
    )


def test_no_lithium_has_no_fraction():
    lines = lines_at(10_000.0, 17.0)

    assert lithium_fraction_curve(lines, fit_plot(lines)) is None


def test_the_fraction_of_spodumene_is_near_that_of_its_formula(reduced):
    _, found = reduced("train", 0)

    assert found.plasma.lithium_fraction == pytest.approx(0.1, abs=0.05)  # LiAlSi2O6: 1 of 10
    assert 0 < found.plasma.lithium_fraction_error < 0.05
