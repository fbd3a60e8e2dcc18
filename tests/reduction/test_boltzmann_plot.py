import numpy as np
import pytest
from test_boltzmann import lines_at

from labrun.reduction.boltzmann import fit_plot
from labrun.reduction.boltzmann_plot import (
    amounts,
    boltzmann_fit,
    boltzmann_points,
    boltzmann_y,
    saha_boltzmann_points,
    saha_shift,
)
from labrun.reduction.lines import lines_of
from labrun.reduction.strengths import atoms

K_EV = 8.617333e-5


def test_the_slope_of_a_boltzmann_plot_is_the_temperature():
    iron = lines_of("Fe")
    own = np.flatnonzero(iron.stage == 1)[::40]
    e_k, g_a = iron.e_k_ev[own], iron.g_k[own] * iron.a_ki_per_s[own]
    area = g_a / iron.wavelength_nm[own] * np.exp(-e_k / (K_EV * 9_500.0))
    y, error = boltzmann_y(
        area, 0.05 * area, iron.wavelength_nm[own], iron.g_k[own], iron.a_ki_per_s[own]
    )
    fit = boltzmann_fit(e_k, y, error)

    assert fit is not None
    assert fit.temperature_k == pytest.approx(9_500.0, rel=1e-5)
    assert fit.at(e_k) == pytest.approx(y, abs=1e-6)
    assert error == pytest.approx(0.05)


def test_its_error_is_the_scatter_of_many_plots():
    rng = np.random.default_rng(2)
    energy = np.linspace(3.0, 7.0, 12)
    fits = [
        boltzmann_fit(energy, -energy / (K_EV * 1e4) + rng.normal(0, 0.1, 12), np.full(12, 0.1))
        for _ in range(400)
    ]
    kelvin = np.array([f.temperature_k for f in fits])
    stated = np.median([f.temperature_error_k for f in fits])

    assert np.std(kelvin) == pytest.approx(stated, rel=0.25)
    assert np.mean(kelvin) == pytest.approx(1e4, rel=0.01)


def test_a_plot_that_rises_or_has_one_level_tells_no_temperature():
    ones = np.ones(3)

    assert boltzmann_fit(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0]), ones) is None
    assert boltzmann_fit(ones, ones, ones) is None


def test_atoms_and_ions_of_all_elements_lie_on_one_line():
    lines = lines_at(10_500.0, 17.0, noise=0.02)
    plot = fit_plot(lines)
    points = saha_boltzmann_points(lines, plot)
    slope, intercept = np.polyfit(points.energy_ev, points.y, 1)
    cool, hot = points.limits(points.energy_ev)

    assert -1 / (K_EV * slope) == pytest.approx(10_500.0, rel=0.03)
    assert intercept == pytest.approx(0.0, abs=0.1)
    assert np.ptp(points.energy_ev[points.ion]) > 1 and set(points.element) == {"Fe", "Mg", "Si"}
    assert np.all(cool < points.line(points.energy_ev)) and np.all(
        points.line(points.energy_ev) < hot
    )
    assert not points.outlier.any()


def test_a_species_points_are_those_of_its_lines_by_hand():
    lines = lines_at(10_000.0, 17.0, noise=0.0)
    energy, y, _ = boltzmann_points(lines, None, "Si", ion=False)
    a = atoms()
    own = (a.elements[lines.element] == "Si") & ~lines.ion

    assert y == pytest.approx(lines.log_area[own] - a.log_ga[lines.rows[own]])
    assert boltzmann_fit(energy, y, np.full(len(y), 0.05)).temperature_k == pytest.approx(
        1e4, rel=0.01
    )


def test_the_shift_of_ions_is_sahas():
    by_hand = 2 * (2 * np.pi * 9.109e-31 * 1.381e-23 * 1e4 / 6.626e-34**2) ** 1.5 / 1e23

    assert np.exp(saha_shift(1e4, 1e17)) == pytest.approx(by_hand, rel=2e-3)


def test_amounts_are_what_was_put_in():
    lines = lines_at(10_000.0, 17.0, noise=0.01)
    twice = lines.log_area + np.where(atoms().elements[lines.element] == "Mg", np.log(2.0), 0.0)
    doubled = type(lines)(twice, *(getattr(lines, n) for n in type(lines).__slots__[1:]))
    log, names = amounts(doubled, fit_plot(doubled), 10_000.0, 1e17)
    mg, si = (atoms().elements[names].tolist().index(e) for e in ("Mg", "Si"))

    assert np.exp(log[mg] - log[si]) == pytest.approx(2.0, rel=0.15)
