"""Grades of made points whose mean is known."""

import numpy as np
import pytest

from labrun.reduction.mapping.grades import drawn_ends
from labrun.reduction.maps.grade import along, by_class, grade
from labrun.reduction.maps.points.contents import ABOVE, BELOW, Contents

NAN = float("nan")


def contents(value, error=0.1, high=NAN, low=NAN, flags=""):
    value = np.asarray(value, dtype=float)
    told = np.isfinite(value)
    flags = np.full(len(value), "", dtype=object) + np.where(told, "", flags).astype(object)
    return Contents(
        value, np.where(told, error, NAN), np.where(told, value - 0.2, low),
        np.where(told, value + 0.2, high), flags,
    )  # fmt: skip


def everywhere(one):
    return np.ones(len(one.value), dtype=bool)


def test_what_a_calibration_errs_stays_in_the_mean_and_single_scatter_does_not():
    rng = np.random.default_rng(1)
    one = contents(1.0 + 0.3 * rng.standard_normal(400))
    found = grade(one, everywhere(one))

    assert found.mean == pytest.approx(1.0, abs=0.05)
    assert found.of_calibration == pytest.approx(0.1)
    assert found.of_variation == pytest.approx(0.3 / 20, rel=0.15)
    assert found.error == pytest.approx(np.hypot(found.of_calibration, found.of_variation))


def test_a_point_below_lod_is_between_0_and_its_limit_and_one_without_a_measurement_does_not_count():
    one = contents([1.0, NAN, NAN], error=0.0, high=0.6, flags=BELOW)
    one.flags[2], one.high[2] = "", NAN
    found = grade(one, everywhere(one))

    assert (found.points, found.below, found.unmeasured) == (2, 1, 1)
    assert found.mean == pytest.approx((1.0 + 0.3) / 2)
    assert found.error >= 0.6 / 12**0.5 / 2
    assert found.said.endswith("wt % (mean of 2 points, 1 of them below LOD, 1 more not measured)")


def test_points_that_are_only_known_to_be_above_make_a_grade_at_least():
    one = contents([1.0, NAN], low=3.0, flags=f"{ABOVE}: the standards end at 3 wt %")
    found = grade(one, everywhere(one))

    assert found.at_least
    assert found.mean == pytest.approx(2.0)
    assert found.said.startswith("at least 2 ")


def test_a_strip_that_is_only_known_to_an_end_is_drawn_as_that_end():
    told = contents([1.0, 3.0])
    below = contents([NAN, NAN], high=0.6, flags="below LOD")
    above = contents([2.0, NAN], low=3.0, flags=f"{ABOVE}: the standards end at 3 wt %")
    each = [grade(one, everywhere(one)) for one in (told, below, above)]
    value, error, least, most = drawn_ends(each)

    assert value.tolist() == pytest.approx([2.0, NAN, NAN], nan_ok=True)
    assert np.isfinite(error).tolist() == [True, False, False]
    assert least.tolist() == pytest.approx([NAN, NAN, 2.5], nan_ok=True)
    assert most.tolist() == pytest.approx([NAN, 0.6, NAN], nan_ok=True)


def test_grains_larger_than_a_step_make_a_mean_less_sure_than_its_points_say():
    rng = np.random.default_rng(2)
    x = np.repeat(np.arange(40.0), 25)
    bands = np.repeat(rng.uniform(0, 2, 8), 125)
    one = contents(bands + 0.05 * rng.standard_normal(1000))
    whole, strips = along(one, everywhere(one), x)

    assert len(strips) == 20
    assert (strips[0].start, strips[-1].end) == (0.0, 39.0)
    assert strips[3].grade.mean == pytest.approx(bands[150:200].mean(), abs=0.1)
    assert whole.of_variation > 2 * np.std(one.value) / np.sqrt(1000)


def test_classes_have_grades_of_their_own_and_points_without_a_class_none():
    one = contents([1.0, 1.0, 3.0, 9.0])
    found = by_class(one, everywhere(one), np.array([0, 0, 1, -1]))

    assert {k: each.mean for k, each in found.items()} == {0: 1.0, 1: 3.0}


def test_nothing_measured_has_no_grade():
    one = contents([NAN, NAN])
    found = grade(one, everywhere(one))

    assert np.isnan(found.mean)
    assert (found.points, found.unmeasured) == (0, 2)
