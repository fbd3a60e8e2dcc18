import numpy as np
import pytest

from labrun.reduction import element_map


def test_points_in_any_order_land_on_their_cells():
    found = element_map([1, 0, 1, 0], [0, 0, 2, 2], [10, 20, 30, 40])

    assert found.values.tolist() == [[20, 10], [40, 30]]


def test_a_missing_point_and_a_missing_row_are_holes():
    found = element_map([0, 1, 0, 1, 0], [0, 0, 1, 1, 3], [1, 2, 3, 4, 5])

    assert found.y.tolist() == [0, 1, 2, 3]
    assert np.isnan(found.values).tolist() == [[0, 0], [0, 0], [1, 1], [0, 1]]


def test_coordinates_that_rounding_moved_share_a_column():
    found = element_map([0.2 * 3, 0.6, 0.8], [0, 1, 0], [1, 2, 3])

    assert found.x.tolist() == [0.6, 0.8]


def test_a_point_measured_twice_gets_the_mean_and_a_failed_shot_does_not_count():
    found = element_map([0, 0, 0], [0, 0, 0], [1, 3, np.nan])

    assert found.values.tolist() == [[2.0]]


def test_scattered_points_do_not_ask_for_an_endless_grid():
    found = element_map([0, 1e-5, 1000], [0, 1, 2], [1, 2, 3])

    assert found.values.shape == (3, 5)


def test_samples_far_apart_are_not_drawn_into_the_gap_between_them():
    found = element_map([0, 1, 0, 1], [0, 1, 200, 201], [1, 2, 3, 4])

    assert found.y.tolist() == [0, 1, 2, 199, 200, 201]
    assert np.isnan(found.values[2:4]).all()


def test_lists_that_do_not_fit_and_places_that_are_none_are_refused():
    with pytest.raises(ValueError, match="not one list"):
        element_map([0, 1], [0], [1])
    with pytest.raises(ValueError, match="not a number"):
        element_map([np.nan], [0], [1])
