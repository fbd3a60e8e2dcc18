from dataclasses import replace

import numpy as np
import pytest

from labrun.reduction.plasma.boltzmann import (
    THICK,
    UNIFORM,
    Bend,
    Known,
    PlotLines,
    fit_plot,
    misfit,
    scatter,
)
from labrun.reduction.plasma.growth import log_depth_of_unit
from labrun.reduction.plasma.plot_fit import trust
from labrun.reduction.plasma.response import LOOSE, OPEN, knots, stiffness

from .uniform_plasma import lines_at


@pytest.mark.parametrize("kelvin", [8_000.0, 10_500.0, 14_000.0])
@pytest.mark.parametrize("log_ne", [16.2, 17.3])
def test_temperature_and_density_of_a_thin_plasma_are_found(kelvin, log_ne):
    plot = fit_plot(lines_at(kelvin, log_ne), thickest=20.0)

    assert plot is not None
    assert plot.temperature_k == pytest.approx(kelvin, rel=0.03)
    assert plot.log10_ne == pytest.approx(log_ne, abs=0.15)
    assert abs(plot.temperature_k - kelvin) < 4 * plot.temperature_error_k


@pytest.mark.parametrize("thickest", [0.5, 20.0])
def test_self_absorption_is_seen_and_does_not_heat_the_plasma(thickest):
    thin = lines_at(10_000.0, 17.0)
    reference = np.max(
        thin.thin(1e4, 1e17) + log_depth_of_unit(thin.vacuum_nm, thin.width_nm, 10_000.0)
    )
    lines = lines_at(10_000.0, 17.0, np.log(20.0) - reference)
    plot = fit_plot(lines, Known(17 * np.log(10), 0.3), thickest=thickest)

    assert plot is not None
    assert plot.temperature_k == pytest.approx(10_000.0, rel=0.04)
    assert plot.kept.min() < 0.5
    assert "strong lines absorb themselves" in plot.flags


def test_a_few_wrong_lines_are_weighed_down():
    lines = lines_at(11_000.0, 17.0)
    lines.log_area[::12] += 1.5
    plot = fit_plot(lines)

    assert plot is not None and plot.temperature_k == pytest.approx(11_000.0, rel=0.05)


def test_three_lines_tell_no_temperature():
    lines = lines_at(11_000.0, 17.0, elements=("Si",))
    few = PlotLines(*(getattr(lines, name)[:3] for name in PlotLines.__slots__))

    assert fit_plot(few) is None


def bend(usual, seams_nm=(500.0,)):
    seams_nm = np.array(seams_nm)
    at = knots((190.0, 961.0), seams_nm)
    return Bend(at, np.zeros(len(at)), stiffness(at, seams_nm, usual))


def test_a_detector_of_another_gain_is_found_and_does_not_change_the_temperature():
    """Iron, silicon and magnesium shine on both sides of 500 nm: one side is 4.5 times too bright."""
    lines = lines_at(10_000.0, 17.0)
    gained = replace(lines, log_area=lines.log_area + 1.5 * (lines.vacuum_nm > 500.0))
    plot = fit_plot(gained, bend=bend(LOOSE))

    assert plot is not None and plot.response is not None
    low, high = plot.response.at(np.array([400.0, 600.0]))
    assert high - low == pytest.approx(1.5, abs=0.3)
    assert plot.temperature_k == pytest.approx(10_000.0, rel=0.05)


def test_a_response_that_may_be_off_widens_the_errors_of_amounts():
    """Lithium shines above 600 nm and silicon mostly below 400: the ratio hangs on the response."""
    lines = lines_at(10_000.0, 17.0, elements=("Li", "Si"))
    sure, unsure = fit_plot(lines), fit_plot(lines, bend=bend(LOOSE))

    assert sure is not None and unsure is not None and sure.response is None
    ratio = np.array([1.0, -1.0])
    assert ratio @ unsure.covariance @ ratio > 2 * ratio @ sure.covariance @ ratio


def test_what_one_zone_lacks_is_more_of_an_error_where_a_free_response_hides_the_temperature():
    """Few lines of neutral silicon: a little more heat looks like a little more gain in the ultraviolet."""
    lines = lines_at(10_000.0, 17.0, elements=("Si",))
    neutral = PlotLines(*(getattr(lines, name)[:12] for name in PlotLines.__slots__))
    known, free = fit_plot(neutral), fit_plot(neutral, bend=bend(OPEN))

    assert known is not None and free is not None
    assert known.blind == 1.0 and 2.0 < free.blind <= 5.0
    lack = free.blind * np.hypot(UNIFORM, THICK * free.lost)
    assert free.temperature_error_k > free.temperature_k * lack


def test_what_one_zone_lacks_is_an_error_of_the_density_too():
    lines = lines_at(10_000.0, 17.0)
    plot = fit_plot(lines)
    lack = np.hypot(UNIFORM, THICK * plot.lost) / np.log(10)

    assert 5 * lack < plot.log10_ne_error < 20 * lack  # Saha's exponent


def test_a_line_that_is_missing_only_says_that_it_is_faint():
    lines = lines_at(10_000.0, 17.0)
    few = lines_at(10_000.0, 17.0, elements=("Si",))
    brighter, fainter = (replace(few, log_area=few.log_area + by) for by in (3.0, -3.0))
    alone, same, less = (fit_plot(lines, missing=m) for m in (None, brighter, fainter))

    assert alone is not None and same is not None and less is not None
    assert same.temperature_k == pytest.approx(alone.temperature_k, rel=1e-3)
    silicon = few.element[0]
    assert less.log_scale[silicon] < alone.log_scale[silicon]


def test_missing_lines_of_an_element_without_another_line_tell_nothing():
    lines, nickel = lines_at(10_000.0, 17.0), lines_at(10_000.0, 17.0, elements=("Ni",))
    alone, told = fit_plot(lines), fit_plot(lines, missing=nickel)

    assert alone is not None and told is not None
    assert told.temperature_k == alone.temperature_k
    assert np.array_equal(told.names, alone.names)
    assert np.isnan(told.log_scale[nickel.element[0]])


def test_scatter_of_the_lines_beyond_their_errors_is_in_the_errors_of_the_plot():
    rng = np.random.default_rng(5)
    lines = lines_at(10_000.0, 17.0)
    off = replace(lines, log_area=lines.log_area + rng.normal(0.0, 0.5, len(lines)))
    plain, told = fit_plot(off), fit_plot(off, scattered=True)
    assert plain is not None and told is not None
    assert told.chi2 == plain.chi2 > 1.0
    assert told.temperature_error_k > 1.3 * plain.temperature_error_k
    assert abs(told.temperature_k - 10_000.0) < 2 * told.temperature_error_k


@pytest.mark.parametrize("more", [0.0, 0.1, 0.5])
def test_misfit_is_what_the_lines_scatter_by_beyond_their_errors(more):
    rng = np.random.default_rng(3)
    sigma = rng.uniform(0.05, 0.3, 2_000)
    found = misfit(rng.normal(0.0, np.hypot(sigma, more)), sigma, len(sigma))
    assert found == pytest.approx(more, rel=0.1, abs=0.03)


@pytest.mark.parametrize("off", [0.7, 1.0, 1.4])
def test_what_lines_scatter_tells_how_well_their_mean_is_known(off):
    lines = np.random.default_rng(8).normal(0.0, off, (2_000, 60))  # in their errors
    mean = np.zeros((2_000, 1))
    for _ in range(12):
        say = trust(lines - mean)
        mean = (say * lines).sum(axis=1, keepdims=True) / say.sum(axis=1, keepdims=True)
    told = [scatter(z, 59) / trust(z).sum() for z in lines - mean]

    assert np.mean(told) == pytest.approx(np.var(mean), rel=0.25)
