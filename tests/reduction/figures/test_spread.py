import numpy as np
import pytest

from labrun.reduction.figures.spread import spread


def test_labels_that_lie_apart_stay_where_they_are():
    assert spread(np.array([1.0, 3.0]), 1.0, 0.0, 10.0).tolist() == [1, 3]


def test_labels_that_crowd_move_as_little_as_they_must():
    assert spread(np.array([4.9, 5.0, 5.1]), 1.0, 0.0, 10.0) == pytest.approx([4, 5, 6])


def test_no_label_leaves_the_page_and_none_touches_another():
    places = np.sort(np.random.default_rng(1).uniform(0, 10, 30))
    found = spread(places, 0.3, 0.0, 10.0)

    assert np.all(np.diff(found) > 0.3 - 1e-9)
    assert found[0] >= 0 and found[-1] <= 10


def test_too_many_labels_are_spaced_evenly():
    assert spread(np.array([5.0, 5, 5]), 10.0, 0.0, 10.0).tolist() == [0, 5, 10]
    assert len(spread(np.empty(0), 1.0, 0.0, 1.0)) == 0
