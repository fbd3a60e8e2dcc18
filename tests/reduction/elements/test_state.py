import pytest

from labrun.reduction.elements.state import mcwhirter_density


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


def test_nothing_is_said_of_a_plasma_without_lines():
    import numpy as np

    from labrun.reduction import Spectrum, reduce_spectrum

    flat = Spectrum(np.linspace(200, 900, 5_000), np.random.default_rng(1).normal(100, 3, 5_000))

    assert reduce_spectrum(flat).temperature_k is None
