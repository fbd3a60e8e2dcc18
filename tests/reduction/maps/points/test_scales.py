import numpy as np
import pytest

from labrun.reduction.mapping.choices import MapChoices, elements_to_show
from labrun.reduction.maps.points.points import Points
from labrun.reduction.maps.points.scales import on_scale, total_light


def points_of(total=np.nan, **areas):
    n = len(next(iter(areas.values())))
    nothing = np.full(n, np.nan)
    area = {e: np.asarray(a, dtype=float) for e, a in areas.items()}
    return Points(
        [str(k) for k in range(n)], [""] * n, np.arange(n) * 1.0, np.zeros(n), "mm", area,
        dict.fromkeys(area, nothing), {}, np.full(n, total), nothing, nothing, nothing,
        np.full(n, -1), None,
    )  # fmt: skip


def test_min_max_goes_from_zero_to_one_and_keeps_holes():
    found = on_scale(points_of(Li=[5, 15, np.nan, 10]), "Li", "min-max")

    assert found.tolist()[:2] == [0, 1] and found[3] == 0.5 and np.isnan(found[2])


def test_a_flat_or_empty_element_is_zero_or_nothing():
    assert on_scale(points_of(Li=[7, 7]), "Li", "min-max").tolist() == [0, 0]
    assert np.isnan(on_scale(points_of(Li=[np.nan]), "Li", "min-max")).all()


def test_part_of_the_total_is_of_all_peaks_where_they_are_known_else_of_the_elements():
    assert on_scale(points_of(Li=[5], K=[15]), "Li", "total").tolist() == [25]
    assert on_scale(points_of(100, Li=[5], K=[15]), "Li", "total").tolist() == [5]
    assert total_light(points_of(Li=[5, np.nan], K=[15, 1])).tolist() == [20, 1]


def test_a_point_without_light_has_no_part_of_it():
    assert np.isnan(on_scale(points_of(Li=[0], K=[0]), "Li", "total")).all()


def test_elements_seen_in_enough_points_are_shown_by_atomic_number():
    rare = [1] + [0] * 49
    shown = elements_to_show(points_of(Si=[1] * 50, Li=[1] * 50, W=rare, Ar=[1] * 50), MapChoices())

    assert shown.elements == ["Li", "Si"]


def test_elements_asked_for_are_shown_as_far_as_they_are_there():
    points = points_of(Li=[1, 2], Si=[1, 2])
    shown = elements_to_show(points, MapChoices(elements=("Si", "Zr")))

    assert shown.elements == ["Si"]
    assert shown.notes == ["there is no area of Zr here"]
    with pytest.raises(ValueError, match="no area of Zr here, only of Li, Si"):
        elements_to_show(points, MapChoices(elements=("Zr",)))


def test_more_elements_than_a_page_takes_are_named():
    many = ("Li", "Na", "Mg", "Al", "Si", "K", "Ca", "Ti", "Mn", "Fe", "Rb", "Sr", "Ba", "Cs")
    shown = elements_to_show(points_of(**{e: [1] * 4 for e in many}), MapChoices())

    assert len(shown.elements) == 12
    assert "Cs, Ba" in shown.notes[0]
