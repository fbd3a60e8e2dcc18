import numpy as np
import pytest
from scipy import constants

from labrun.reduction.plasma.growth import HC_BY_K_NM_K, growing, log_kept, log_radiance


def by_hand(tau):
    """Equivalent width of a Lorentzian slab over its thin limit, by summing."""
    x = np.linspace(-4_000, 4_000, 2_000_001)
    return float(np.sum(-np.expm1(-tau / (1 + x**2))) / np.sum(tau / (1 + x**2)))


@pytest.mark.parametrize("tau", [1e-3, 0.3, 1.0, 10.0, 300.0])
def test_the_curve_of_growth_is_that_of_a_slab(tau):
    assert np.exp(log_kept(np.log(tau))[0]) == pytest.approx(by_hand(tau), rel=0.01)


def test_its_slope_is_the_limit_of_differences():
    at = np.linspace(-6, 6, 25)
    difference = (log_kept(at + 0.05)[0] - log_kept(at - 0.05)[0]) / 0.1

    assert np.allclose(log_kept(at)[1], difference, atol=2e-3)
    assert growing(np.exp(log_kept(at)[0])) == pytest.approx(1 + difference, abs=3e-3)


def test_the_radiance_is_plancks():
    nm = np.array([250.0, 500.0, 900.0])
    by_hand = nm**-5 / np.expm1(HC_BY_K_NM_K / (nm * 10_000.0))
    ratio = np.exp(log_radiance(nm, 10_000.0)) / by_hand

    assert pytest.approx(1e9 * constants.h * constants.c / constants.k) == HC_BY_K_NM_K
    assert ratio == pytest.approx(ratio[0])
