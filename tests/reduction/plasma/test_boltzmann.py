import numpy as np
import pytest

from labrun.reduction.plasma.boltzmann import Known, PlotLines, fit_plot
from labrun.reduction.plasma.growth import log_depth_of_unit

from .uniform_plasma import lines_at


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
