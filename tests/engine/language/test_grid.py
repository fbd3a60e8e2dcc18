"""Spans and grids: exact, lazy, in every order."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from labrun.engine.language.grid import GridFault, grid, span
from labrun.schemas.quantity import parse_quantity, quantity_text


def test_a_span_holds_both_ends_and_no_noise():
    values = list(span(0, 4, 0.2))

    assert len(values) == 21
    assert values[3] == 0.6 and values[-1] == 4.0


def test_a_span_of_quantities_has_the_unit_of_its_start():
    values = span(0, parse_quantity("1 mm"), parse_quantity("250 um"))

    assert [quantity_text(value) for value in values] == [
        "0 mm",
        "0.25 mm",
        "0.5 mm",
        "0.75 mm",
        "1 mm",
    ]


def test_a_span_may_go_down_and_may_be_one_item():
    assert list(span(3, 1, -1)) == [3, 2, 1]
    assert list(span(2, 2, 0.5)) == [2.0]


def test_a_step_that_does_not_divide_is_refused_unless_it_may_end_inside():
    with pytest.raises(GridFault, match=r"end at 0\.9, not at 1"):
        span(0, 1, 0.3)

    assert list(span(0, 1, 0.3, fit="inside")) == [0.0, 0.3, 0.6, 0.9]


@pytest.mark.parametrize(
    "arguments",
    [(0, 1, 0), (0, 1, -1), (0, 1, "a"), (0, 1e12, 1), (0, True, 1), (0, 1, 1, "outside")],
)
def test_impossible_spans_are_refused(arguments):
    with pytest.raises(GridFault):
        span(*arguments)


@pytest.mark.parametrize(
    ("order", "places"),
    [
        ("rows", [(0, 0), (1, 0), (2, 0), (0, 1), (1, 1), (2, 1)]),
        ("snake", [(0, 0), (1, 0), (2, 0), (2, 1), (1, 1), (0, 1)]),
        ("columns", [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)]),
    ],
)
def test_the_orders_of_a_grid(order, places):
    points = grid(x=[10, 20, 30], y=span(0, 1, 1), order=order)

    assert [(p["ix"], p["iy"]) for p in points] == places
    assert [p["index"] for p in points] == list(range(6))
    assert points[-1] == points[5]
    assert [points.index_of(p["ix"], p["iy"]) for p in points] == list(range(6))


def test_a_grid_of_a_thousand_million_points_is_no_list():
    points = grid(x=span(0, 30_000, 1), y=span(0, 30_000, 1), order="snake")

    assert len(points) == 30_001 * 30_001
    assert points[len(points) - 1]["y"] == 30_000
    assert points.corners() == [0, 30_000, len(points) - 30_001, len(points) - 1]


@given(st.integers(1, 400), st.sampled_from([0.1, 0.2, 0.02, 0.7, 1e-3, 2.5, 33.3]))
def test_every_whole_number_of_steps_divides(count, step):
    values = span(0, count * step, step)

    assert len(values) == count + 1
    assert values[-1] == pytest.approx(count * step)
