import numpy as np
import pytest
from truth import make_spectrum
from truth.atoms import ions_per_atom, partition
from truth.instrument import air_of, vacuum_of
from truth.light import planck
from truth.score import pairs

from labrun.reduction.lines.air import to_air
from labrun.reduction.plasma.growth import log_radiance
from labrun.reduction.plasma.plasma import saha_ratio


def test_a_seed_is_a_spectrum():
    one, two = make_spectrum("train", 2), make_spectrum("train", 2)

    assert np.array_equal(one.intensity, two.intensity, equal_nan=True)
    assert one.present == two.present


def test_two_who_never_met_agree_on_saha_planck_and_air():
    nm = np.linspace(200, 950, 50)

    assert ions_per_atom("Ca", 10_000.0, 1e17) == pytest.approx(
        saha_ratio("Ca", 10_000.0, 1e17), rel=0.1
    )
    ratio = np.log(planck(nm, 9_000.0) / planck(nm, 12_000.0))
    assert np.allclose(ratio, log_radiance(nm, 9_000.0) - log_radiance(nm, 12_000.0), atol=1e-6)
    assert np.allclose(air_of(nm), to_air(nm), atol=2e-5)
    assert np.allclose(vacuum_of(air_of(nm)), nm, atol=1e-8)


def test_a_cold_lithium_atom_is_in_its_ground_state():
    assert partition("Li", 1, 500.0) == pytest.approx(2.0)


def test_the_area_of_a_lonely_line_is_the_sum_of_its_channels():
    truth = make_spectrum("train", 5)
    g = truth.groups
    strong = np.flatnonzero(g.alone & (g.height > 100 * g.noise))
    net = truth.intensity - truth.continuum
    pitch = np.gradient(truth.wavelength_nm)
    for k in strong:
        near = np.abs(truth.wavelength_nm - g.shown_nm[k]) < 0.35
        if truth.bad[near].any():
            continue
        assert np.sum(net[near] * pitch[near]) == pytest.approx(g.area[k], rel=0.1)

    assert len(strong)


def test_pairs_are_one_to_one_and_nearest_first():
    found, true = np.array([1.0, 1.03, 5.0]), np.array([1.02, 4.97])

    assert sorted(pairs(found, true, 0.05)) == [(1, 0), (2, 1)]
