from dataclasses import replace

import numpy as np
import pytest

from labrun.reduction.plasma.boltzmann import Bend, Known, fit_plot
from labrun.reduction.plasma.growth import log_depth_of_unit
from labrun.reduction.plasma.lithium_share import COOL_FROM, lithium_share, share_curve
from labrun.reduction.plasma.plot_fit import COOLEST_K
from labrun.reduction.plasma.strengths import atoms
from labrun.reduction.tables.plot import cation_fraction

from .uniform_plasma import lines_at

LEVEL = Bend(np.empty(0), np.empty(0), np.empty((0, 0)))
KELVIN, LOG_NE = 10_000.0, 17.0


def plot_with_lithium(share, kelvin=10_000.0, log_ne=17.0):
    """Lines of Li and Si, so many atoms of lithium among them; no line absorbs itself."""
    both = lines_at(kelvin, log_ne, noise=0.01, elements=("Li", "Si"))
    is_li = atoms().elements[both.element] == "Li"
    area = both.log_area + np.where(is_li, np.log(share), np.log(1 - share))
    lines = type(both)(area, *(getattr(both, name) for name in type(both).__slots__[1:]))
    return lines, fit_plot(lines, Known(log_ne * np.log(10), 0.1)), LEVEL


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
    lines, plot, _ = plot_with_lithium(0.1)
    kelvin, share, low, high = share_curve(lines, plot, LEVEL)

    assert np.interp(plot.temperature_k, kelvin, share) == pytest.approx(
        lithium_share(lines, plot, LEVEL).share
    )
    assert np.all((low > 0) & (low < high) & (high < 1))
    assert np.ptp(share) > 0


def behind_a_shell(part, share=0.2):
    """Thick lines, a part of whose atoms is in a cool shell, integrated along the profile."""
    lines = lines_at(KELVIN, LOG_NE, noise=0.02, elements=("Li", "Si", "Al", "Mg", "Fe"))
    lines = lines.where(~lines.ion | (atoms().elements[lines.element] != "Li"))  # of 60 eV
    is_li = atoms().elements[lines.element] == "Li"
    amount = np.where(is_li, np.log(share), np.log((1 - share) / 4))
    angle = np.linspace(-1.5, 1.5, 401)
    at, light, opacity = np.tan(angle), 0.0, None
    for atoms_there, cooler, fewer in ((1 - part, 1.0, 1.0), (part, 0.6, 0.3)):
        kelvin = cooler * KELVIN
        thin = np.log(atoms_there) + amount + lines.thin(kelvin, fewer * 10**LOG_NE)
        depth = thin + log_depth_of_unit(lines.vacuum_nm, fewer * lines.width_nm, kelvin)
        opacity = np.log(300.0) - depth.max() if opacity is None else opacity
        tau = np.exp(opacity + depth)[:, None] / (1 + (at / fewer) ** 2)
        light = light * np.exp(-tau) - np.exp(thin - depth)[:, None] / fewer * np.expm1(-tau)
    noise = 0.02 * np.random.default_rng(3).standard_normal(len(lines))
    return replace(lines, log_area=np.log(light @ (1 + at**2)) + noise)


@pytest.mark.parametrize("part", [1e-6, 0.25])
def test_lines_of_a_thick_plasma_tell_the_share_with_and_without_a_cool_shell(part):
    lines = behind_a_shell(part)
    plot = fit_plot(lines, Known(LOG_NE * np.log(10), 0.1))
    found = lithium_share(lines, plot, LEVEL)
    by = np.log(found.high / (1 - found.high) * (1 - found.low) / found.low) / 2
    off = np.log(found.share / (1 - found.share) / 0.25)

    assert plot.lost > COOL_FROM
    assert abs(off) < 0.25  # one zone: 0.47 behind the shell
    assert 0.1 < by < 0.25


def test_no_lithium_has_no_share():
    lines = lines_at(10_000.0, 17.0)

    assert lithium_share(lines, fit_plot(lines), LEVEL) is None


def test_a_temperature_at_the_bound_of_the_fit_tells_no_share():
    lines, plot, _ = plot_with_lithium(0.1)

    assert lithium_share(lines, replace(plot, temperature_k=COOLEST_K), LEVEL) is None


def test_the_share_in_spodumene_is_near_that_of_its_formula(reduced):
    _, found = reduced("train", 0)
    share = cation_fraction(found)

    assert share.share == pytest.approx(0.25, abs=0.1)  # LiAlSi2O6: 1 of 4 cations
    assert 0 < share.share_error < 0.15
