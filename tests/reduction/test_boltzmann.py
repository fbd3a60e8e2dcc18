import numpy as np
import pytest

from labrun.reduction.boltzmann import Known, PlotLines, fit_plot
from labrun.reduction.growth import log_depth_of_unit, log_kept
from labrun.reduction.strengths import atoms, log_strengths


def lines_at(kelvin, log_ne, log_opacity=-60.0, noise=0.03, seed=0, elements=("Si", "Fe", "Mg")):
    """Bright lines of a few elements with the areas of a uniform plasma."""
    a, rng = atoms(), np.random.default_rng(seed)
    rows = []
    for symbol in elements:
        for ion in (False, True):
            own = np.flatnonzero((a.elements[a.element] == symbol) & (a.ion == ion))
            rows.append(own[np.argsort(-log_strengths(own, kelvin, 10**log_ne))[:25]])
    rows = np.concatenate(rows)
    thin = log_strengths(rows, kelvin, 10**log_ne)
    width = a.width_nm[rows] * 10 ** (log_ne - 17)
    log_tau = log_opacity + thin + log_depth_of_unit(a.wavelength_nm[rows], width, kelvin)
    area = thin + log_kept(log_tau)[0] + noise * rng.standard_normal(len(rows))
    return PlotLines(
        area, np.full(len(rows), noise), a.element[rows], rows, np.arange(len(rows)),
        a.wavelength_nm[rows], a.width_nm[rows], a.e_k_ev[rows], a.ion[rows],
    )  # fmt: skip


@pytest.mark.parametrize("kelvin", [8_000.0, 10_500.0, 14_000.0])
@pytest.mark.parametrize("log_ne", [16.2, 17.3])
def test_temperature_and_density_of_a_thin_plasma_are_found(kelvin, log_ne):
    plot = fit_plot(lines_at(kelvin, log_ne))

    assert plot is not None
    assert plot.temperature_k == pytest.approx(kelvin, rel=0.03)
    assert plot.log10_ne == pytest.approx(log_ne, abs=0.15)
    assert abs(plot.temperature_k - kelvin) < 4 * plot.temperature_error_k


def test_self_absorption_is_seen_and_does_not_heat_the_plasma():
    thin = lines_at(10_000.0, 17.0)
    reference = np.max(
        thin.thin(1e4, 1e17) + log_depth_of_unit(thin.vacuum_nm, thin.width_nm, 10_000.0)
    )
    plot = fit_plot(lines_at(10_000.0, 17.0, np.log(20.0) - reference), Known(17 * np.log(10), 0.3))

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
