import numpy as np

from labrun.reduction.maps.classes.features import feature_table, scaled


def test_one_wild_point_moves_nobody_else():
    area = np.concatenate([np.zeros(50), np.linspace(90, 110, 49), [1e6]])
    found = scaled(area)

    assert found[60] > 0.8 and found[-1] == 1.25


def test_an_element_that_few_points_have_still_reaches_one():
    found = scaled(np.array([0.0] * 95 + [10.0] * 5))

    assert found.max() == 1 and found.min() == 0


def test_what_is_missing_negative_or_nowhere_counts_as_nothing():
    found = feature_table([np.array([np.nan, -3.0, 5.0]), np.zeros(3)])

    assert found.tolist() == [[0, 0], [0, 0], [1, 0]]
