"""Curves against standards whose scatter is known, many times over."""

import numpy as np
import pytest

from labrun.reduction.calibration.curve import cross_validated, fit_curve

CONTENTS = np.array([0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0, 1.0])


def drawn(rng, c, shots, floor=2.0, part=0.1, between=0.08, bend=0.0):
    """Mean signals: 20 + 1000 c (1 - bend c), with scatter of shots and of standards."""
    f = 20 + 1000 * c * (1 - bend * c)
    f = f * (1 + between * rng.standard_normal(np.shape(c)))
    return f + np.sqrt((floor**2 + (part * f) ** 2) / shots) * rng.standard_normal(np.shape(c))


def test_without_scatter_the_curve_is_the_truth():
    signal = 20 + 1000 * CONTENTS
    curve = fit_curve(CONTENTS, signal, np.full(10, 5.0), 1e-3, 1e-6, 1)

    assert curve.signal(np.array([0.0, 0.5])) == pytest.approx([20, 520], rel=1e-3)
    assert curve.read(520.0).wt_percent == pytest.approx(0.5, rel=1e-3)
    assert curve.read(0.0).wt_percent == pytest.approx(-0.02, rel=0.02)
    assert curve.slope(0.3) == pytest.approx(1000, rel=1e-3)


def test_limits_are_three_and_ten_standard_deviations_of_a_blank_over_the_slope():
    curve = fit_curve(CONTENTS, 20 + 1000 * CONTENTS, np.full(10, 400.0), 6.0, 0.0, 1)

    assert curve.lod() == pytest.approx(3 * 6.0 / 1000, rel=0.02)
    assert curve.loq() == pytest.approx(10 * 6.0 / 1000, rel=0.02)
    assert curve.lod(shots=9) == pytest.approx(3 * 2.0 / 1000, rel=0.05)
    assert curve.lod(noise=12.0) == pytest.approx(3 * 12.0 / 1000, rel=0.02)


@pytest.mark.parametrize(("degree", "bend"), [(1, 0.0), (2, 0.3)])
def test_intervals_hold_as_often_as_they_say(degree, bend):
    rng = np.random.default_rng(11)
    in_68 = in_95 = n = 0
    for _ in range(35):
        shots = np.full(10, 5.0)
        signal = drawn(rng, CONTENTS, shots, bend=bend)
        curve = fit_curve(CONTENTS, signal, shots, 2.0, 0.1, degree)
        truth = rng.uniform(0.03, 0.9, 12)
        for c, signal in zip(truth, drawn(rng, truth, 5.0, bend=bend), strict=True):
            told = curve.read(float(signal), shots=5)
            in_68 += abs(told.wt_percent - c) <= told.error
            in_95 += told.low <= c <= told.high
            n += 1

    assert 0.60 < in_68 / n < 0.78
    assert 0.90 < in_95 / n < 0.985


def test_leverages_sum_to_the_coefficients_and_a_standard_apart_bears_the_curve():
    c = np.array([0.0, 0.05, 0.1, 0.12, 1.0])
    shots = np.array([5.0, 5.0, 5.0, 5.0, 1.0])
    curve = fit_curve(c, 20 + 1000 * c, shots, 6.0, 0.0, 1)
    found = curve.leverage(c, shots)

    assert found.sum() == pytest.approx(2.0, rel=0.02)
    assert found[4] > 0.7 > 0.5 > found[:4].max()


def test_a_quadratic_ends_at_its_top_and_says_no_upper_end_beyond():
    signal = 1000 * CONTENTS * (1 - 0.4 * CONTENTS)
    curve = fit_curve(CONTENTS, signal, np.full(10, 5.0), 2.0, 0.0, 2)

    assert curve.top == pytest.approx(1.25, rel=0.02)
    assert curve.read(900.0).high == np.inf
    assert curve.read(900.0).low == pytest.approx(1.25, rel=0.05)


def test_cross_validation_reads_each_standard_by_the_others():
    c = CONTENTS[1:-1]
    signal = 1000 * c
    signal[4] *= 3.0
    shots = np.full(len(c), 5.0)
    found = cross_validated(fit_curve(c, signal, shots, 0.5, 0.01, 1), c, signal, shots)

    assert found[4] == pytest.approx(3 * c[4], rel=0.2)
    assert found[0] == pytest.approx(c[0], abs=0.03)
