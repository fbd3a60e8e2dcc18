import numpy as np
import pytest

from labrun.reduction.maps.classes.classify import NONE, classify
from labrun.reduction.maps.points.points import Points


def points_of(**areas):
    n = len(next(iter(areas.values())))
    nothing = np.full(n, np.nan)
    area = {e: np.asarray(a, dtype=float) for e, a in areas.items()}
    return Points(
        [str(k) for k in range(n)], [""] * n, np.arange(n) * 1.0, np.zeros(n), "mm", area,
        dict.fromkeys(area, nothing), {}, nothing, nothing, nothing, nothing, np.full(n, -1), None,
    )  # fmt: skip


def test_a_point_without_signal_is_in_no_class():
    classes = classify(points_of(Li=[9, 8, 0, 1, 0], H=[0, 0, 0, 9, 0], K=[0, 0, 0, 0, 3]))

    assert classes.label[2] == NONE and classes.label[4] != NONE
    assert np.isnan(classes.silhouette[2])
    assert any("a point has no signal" in note for note in classes.notes)


def test_a_hole_is_not_a_point_without_signal():
    classes = classify(points_of(Li=[9, 8, np.nan, 1], H=[0, 0, np.nan, 9]))

    assert classes.label[2] == NONE
    assert any("not measured" in note for note in classes.notes)


def test_a_class_has_the_mean_of_every_element_with_its_error():
    classes = classify(points_of(Li=[10, 12, 0, 0], K=[1, 1, 5, 7]), ("Li",), 2)
    first = classes.summary[0]

    assert (first.size, first.area["Li"], first.area["K"]) == (2, 11, 1)
    assert first.error["Li"] == pytest.approx(1.0)


def test_without_hydrogen_other_elements_tell_and_that_is_said():
    classes = classify(points_of(Li=[9, 8, 0, 0], K=[0, 0, 9, 8]))

    assert classes.features == ("Li", "K")
    assert "based on Li, K" in classes.notes[0]


def test_a_feature_that_is_nowhere_is_left_out_with_a_sentence():
    points = points_of(Li=[9, 8, 0.5, 1])

    assert "Rb is not seen anywhere" in classify(points, ("Li", "Rb")).notes[0]
    with pytest.raises(ValueError, match="no classes without a feature"):
        classify(points, ("Rb",))


def test_points_that_are_all_alike_are_one_class():
    classes = classify(points_of(Li=[5, 5, 5], H=[1, 1, 1]))

    assert classes.label.tolist() == [0, 0, 0]
    assert len(classes) == 1
