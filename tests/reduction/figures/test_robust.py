import numpy as np
import pytest

from labrun.reduction.figures.robust import Limits, robust_limits


@pytest.mark.parametrize("size", [(10, 12), (40, 50)])
def test_one_hot_pixel_does_not_set_the_scale_and_is_counted(size):
    values = np.random.default_rng(2).uniform(10, 20, size)
    values[3, 4], values[5, 5] = 4_000.0, np.nan
    limits = robust_limits(values)

    assert 10 <= limits.lowest < 10.5 and 19.5 < limits.highest <= 20
    assert (limits.below, limits.above, limits.said) == (0, 1, "1 above")


def test_both_ends_may_be_wild():
    values = np.random.default_rng(2).normal(0, 1, 1_000)
    values[:3], values[3:5] = 90.0, -80.0

    assert robust_limits(values).said == "2 below, 3 above"


@pytest.mark.parametrize(
    "values",
    [
        np.random.default_rng(2).normal(0, 1, 500),
        np.repeat([0.0, 100.0], [90, 10]),  # one grain in ten is what a map is drawn for
        np.array([1.0, 2.0, 900.0]),
        np.full(50, 3.0),
    ],
)
def test_what_belongs_to_the_others_stays_on_the_scale(values):
    assert robust_limits(values) == Limits(float(values.min()), float(values.max()))


def test_nothing_known_has_a_scale():
    assert robust_limits(np.full(4, np.nan)) == Limits(0.0, 1.0)
