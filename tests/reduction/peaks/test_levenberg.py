import numpy as np
import pytest

from labrun.reduction.peaks.levenberg import evaluate, fit

X = np.linspace(-1, 1, 80)
TWO_ON_A_SLOPE = np.array([90.0, -0.1, 0.08, 0.03, 40.0, 0.25, 0.05, 0.06, 10.0, 3.0])


def model_at(p):
    model, jacobian = np.empty(len(X)), np.empty((len(p), len(X)))
    evaluate(p, X, model, jacobian)
    return model, jacobian


@pytest.mark.parametrize("which", range(len(TWO_ON_A_SLOPE)))
def test_the_analytic_slope_of_each_parameter_is_the_limit_of_differences(which):
    step = np.zeros(len(TWO_ON_A_SLOPE))
    step[which] = 1e-6
    difference = (model_at(TWO_ON_A_SLOPE + step)[0] - model_at(TWO_ON_A_SLOPE - step)[0]) / 2e-6

    assert np.allclose(model_at(TWO_ON_A_SLOPE)[1][which], difference, rtol=1e-5, atol=1e-4)


def test_two_overlapping_peaks_without_noise_are_recovered_exactly():
    y = model_at(TWO_ON_A_SLOPE)[0]
    p = TWO_ON_A_SLOPE * 1.2
    free = np.full(len(p), np.inf)
    lowest = np.where(np.arange(len(p)) % 4 == 2, 0.01, -np.inf)
    _, _, settled = fit(
        p, X, y, np.full(len(X), 1e6), np.zeros(len(p)), np.zeros(len(p)), lowest, free
    )

    assert settled
    assert p == pytest.approx(TWO_ON_A_SLOPE, rel=1e-3)


def test_a_parameter_at_its_bound_stays_inside():
    truth = np.array([50.0, 0.0, 0.1, 0.0, 0.0, 0.0])
    y = model_at(truth)[0] + np.random.default_rng(2).normal(0, 1, len(X))
    lowest = np.array([0.0, -0.5, 0.01, 0.0, -np.inf, -np.inf])
    p = truth + np.array([5.0, 0.02, 0.02, 0.05, 0.0, 0.0])
    fit(p, X, y, np.ones(len(X)), np.zeros(6), np.zeros(6), lowest, np.full(6, np.inf))

    assert np.all(p >= lowest)
    assert p[:3] == pytest.approx(truth[:3], abs=2.0)


def test_a_parameter_that_is_pulled_gives_way_to_the_peak():
    truth = np.array([50.0, 0.0, 0.1, 0.1, 0.0, 0.0])
    y = model_at(truth)[0]
    lowest = np.array([0.0, -0.5, 0.01, 0.0, -np.inf, -np.inf])
    heights = []
    for pull in (0.0, 1e9):
        p = truth + np.array([0.0, 0.0, 0.0, 0.0, 20.0, 0.0])
        fit(
            p,
            X,
            y + 5,
            np.ones(len(X)),
            np.zeros(6),
            np.array([0, 0, 0, 0, pull, 0]),
            lowest,
            np.full(6, np.inf),
        )
        heights.append(p[4])

    assert heights == pytest.approx([5.0, 0.0], abs=0.1)
