import numpy as np
import pytest

from labrun.reduction.maps.classes.kmeans import choose, split


def blobs(k=4, n=40, seed=1):
    random = np.random.default_rng(seed)
    centres = np.array([[0, 0], [3, 0], [0, 3], [5, 5], [9, 1]])[:k]
    return np.concatenate([c + 0.2 * random.normal(size=(n, 2)) for c in centres])


def test_groups_that_lie_apart_are_found_and_counted():
    k, scores = choose(blobs())

    assert k == 4
    assert scores[4] > 0.8 and set(scores) == set(range(2, 9))


def test_classes_are_numbered_from_the_highest_first_feature():
    x = blobs()
    label = split(x, 4)
    means = [x[label == c, 0].mean() for c in range(4)]

    assert means == sorted(means, reverse=True)


def test_any_order_of_rows_gets_the_same_labels():
    x = blobs(seed=5) + np.random.default_rng(2).normal(size=(160, 2))
    order = np.random.default_rng(3).permutation(len(x))

    assert split(x[order], 5).tolist() == split(x, 5)[order].tolist()


def test_equal_points_are_in_one_class():
    label = split(np.repeat(np.array([[0.0], [1.0]]), 5, axis=0), 2)

    assert label.tolist() == [1] * 5 + [0] * 5


def test_alike_or_too_few_points_are_one_class():
    assert choose(np.ones((20, 2))) == (1, {})
    assert choose(np.array([[0.0], [1.0]])) == (1, {})


def test_more_classes_than_different_points_are_refused():
    with pytest.raises(ValueError, match="2 different points cannot be split into 3"):
        split(np.array([[0.0], [1.0], [1.0]]), 3)


def test_many_points_choose_by_a_part_of_them():
    k, _ = choose(blobs(k=3, n=2_000))

    assert k == 3
