from dataclasses import replace

import numpy as np
import pytest

from labrun.reduction.elements.state import mcwhirter_density, plasma_state


def test_the_criterion_is_mcwhirters():
    assert mcwhirter_density(10_000.0, 3.0) == pytest.approx(1.6e12 * 100 * 27)


def test_the_plasma_of_spodumene_is_known(reduced):
    truth, found = reduced("train", 0)
    plasma = found.plasma

    assert plasma.method == "saha-boltzmann"
    assert plasma.temperature_k == pytest.approx(truth.kelvin, rel=0.05)
    assert plasma.log10_ne == pytest.approx(truth.log10_ne, abs=0.3)
    assert plasma.mcwhirter
    assert plasma.lithium is not None and plasma.lithium.temperature_k > 4_000


@pytest.mark.parametrize("bound", [np.log10(3e18), 15.0])
def test_a_density_at_the_bound_of_the_fit_is_no_measurement(reduced, bound):
    _, found = reduced("train", 0)
    plot = replace(found.identified.plot, log10_ne=float(bound))
    plasma = plasma_state(found.peaks, replace(found.identified, plot=plot, hydrogen=None))

    assert plasma.log10_ne is None and plasma.mcwhirter is None
    assert plasma.temperature_k == plot.temperature_k


def test_a_temperature_at_the_bound_of_the_fit_is_no_measurement(reduced):
    _, found = reduced("train", 0)
    plot = replace(found.identified.plot, temperature_k=19_000.0)

    assert (
        plasma_state(found.peaks, replace(found.identified, plot=plot)).method != "saha-boltzmann"
    )


def test_nothing_is_said_of_a_plasma_without_lines():
    from labrun.reduction import Spectrum, reduce_spectrum

    flat = Spectrum(np.linspace(200, 900, 5_000), np.random.default_rng(1).normal(100, 3, 5_000))

    assert reduce_spectrum(flat).temperature_k is None
