import numpy as np
import pytest
from scipy import constants
from scipy.special import ive

from labrun.reduction.plasma.growth import (
    HC_BY_K_NM_K,
    growing,
    growth_table,
    log_kept,
    log_radiance,
)


def by_hand(tau):
    """Equivalent width of a Lorentzian slab over its thin limit, by summing."""
    x = np.linspace(-4_000, 4_000, 2_000_001)
    return float(np.sum(-np.expm1(-tau / (1 + x**2))) / np.sum(tau / (1 + x**2)))


@pytest.mark.parametrize("tau", [1e-3, 0.3, 1.0, 10.0, 300.0])
def test_the_curve_of_growth_is_that_of_a_slab(tau):
    assert np.exp(log_kept(np.log(tau))) == pytest.approx(by_hand(tau), rel=0.01)


def test_its_table_is_of_bessel_functions():
    log_tau, log_f, slope = growth_table()
    known = log_tau < 20.0  # scipy has no value for the thickest
    zero, one = (ive(order, 0.5 * np.exp(log_tau[known])) for order in (0, 1))
    limit = 0.5 * np.log(4.0 / (np.pi * np.exp(log_tau[~known])))

    assert np.allclose(log_f[known], np.log(zero + one), rtol=1e-11, atol=1e-14)
    assert np.allclose(slope[known], -one / (zero + one), rtol=1e-11)
    assert np.allclose(log_f[~known], limit, rtol=1e-8)
    assert np.allclose(slope[~known], -0.5, rtol=1e-8)


def test_its_slope_is_the_limit_of_differences():
    at = np.linspace(-6, 6, 25)
    difference = (log_kept(at + 0.05) - log_kept(at - 0.05)) / 0.1

    assert growing(np.exp(log_kept(at))) == pytest.approx(1 + difference, abs=3e-3)


def test_the_radiance_is_plancks():
    nm = np.array([250.0, 500.0, 900.0])
    by_hand = nm**-5 / np.expm1(HC_BY_K_NM_K / (nm * 10_000.0))
    ratio = np.exp(log_radiance(nm, 10_000.0)) / by_hand

    assert pytest.approx(1e9 * constants.h * constants.c / constants.k) == HC_BY_K_NM_K
    assert ratio == pytest.approx(ratio[0])
