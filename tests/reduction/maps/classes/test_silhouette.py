import numpy as np
import pytest

from labrun.reduction.maps.classes.silhouette import silhouettes


def test_a_hand_computed_case():
    """(b - a) / max(a, b): of 0 among {0, 1} beside {4, 6}, a = 1 and b = 5."""
    found = silhouettes(np.array([[0.0], [1.0], [4.0], [6.0]]), np.array([0, 0, 1, 1]))

    assert found.tolist() == pytest.approx([0.8, 0.75, 1.5 / 3.5, 3.5 / 5.5])


def test_a_point_alone_and_a_single_class_have_none():
    x = np.array([[0.0], [1.0], [9.0]])

    assert silhouettes(x, np.array([0, 0, 1]))[2] == 0
    assert silhouettes(x, np.zeros(3, dtype=int)).tolist() == [0, 0, 0]


def test_of_very_many_points_a_part_stands_for_all():
    random = np.random.default_rng(0)
    label = np.arange(9_000) % 2
    x = (5.0 * label + random.normal(size=9_000))[:, None]
    few = silhouettes(x[:2_000], label[:2_000])

    assert np.mean(silhouettes(x, label)) == pytest.approx(np.mean(few), abs=0.01)
