"""Checking all points of a long loop at once finds the same as trying every point."""

import math

import pytest

from labrun.engine.check import check_text
from labrun.engine.checks.points import first_outside, is_long
from labrun.engine.language.expression import expression
from labrun.engine.language.fold import Folding
from labrun.engine.language.grid import grid, span
from labrun.engine.language.value import Computed
from labrun.schemas.quantity import magnitude_in, parse_quantity

MM = parse_quantity("1 mm")
BARE = grid(x=span(0, 9, 0.1), y=span(0, 9, 0.25), order="snake")
LENGTHS = grid(
    x=span(0 * MM, 9 * MM, 0.1 * MM), y=span(0 * MM, 1 * MM * 9, 0.25 * MM), order="columns"
)


def each(value, name, folding, unit):
    """The number at every item of a loop, one after the other."""
    for item in folding.loops[name]:
        found = value.evaluate({**folding.names, "params": folding.params, name: item})
        yield magnitude_in(found, unit) if unit else found


@pytest.mark.parametrize("points", [BARE, LENGTHS], ids=["bare", "lengths"])
@pytest.mark.parametrize(
    "text",
    [
        "p.x * (p.x - params.w) / params.one", "-p.x * p.y / params.one + params.w",
        "max(p.x, p.y) + params.w", "min(p.x, params.w) * 2", "p.x ** 2 / params.one",
        "params.w / (p.ix + 1) * p.iy", "p.index ** 2 * params.one / 1000000",
        "2 * p.y - p.x * p.ix / 50",
    ],
)  # fmt: skip
def test_the_first_point_outside_is_the_one_that_trying_each_finds(points, text):
    one = MM if points is LENGTHS else 1.0
    folding = Folding({"w": 4 * one, "one": one}, {}, {"p": points})
    value = Computed(expression(text))
    unit = "mm" if points is LENGTHS else None
    numbers = list(each(value, "p", folding, unit))

    assert is_long(value, ["p"], folding)
    for low, high in [(-math.inf, 8.0), (-3.0, math.inf), (0.0, 1e6), (-1e6, 1e6)]:
        wanted = next((n for n, number in enumerate(numbers) if not low <= number <= high), None)
        found = first_outside(
            value, ["p"], folding, unit,
            low if low > -math.inf else None, high if high < math.inf else None,
        )  # fmt: skip
        assert (found.names["p"]["index"] if found else None) == wanted, (low, high)


def test_sums_over_even_spans_are_decided_by_their_ends():
    folding = Folding({}, {}, {"p": BARE})

    assert not is_long(Computed(expression("p.x + p.y")), ["p"], folding)


def test_two_loops_around_one_value_are_taken_together():
    folding = Folding({}, {}, {"a": span(0, 99, 1), "b": span(0, 99, 1)})
    found = first_outside(Computed(expression("a * b")), ["a", "b"], folding, None, None, 99 * 98)

    assert found is not None
    assert (found.names["a"], found.names["b"]) == (99, 99)


def test_what_cannot_be_computed_so_is_left_alone():
    folding = Folding({}, {"name": "Li"}, {"p": BARE})

    for text in ("name", "format(p.x, '.2f')", "p.z", "p.x if p.ix else p.y", "unknown + p.x"):
        assert first_outside(Computed(expression(text)), ["p"], folding, None, 0, 1) is None


def test_a_hole_in_the_middle_of_a_large_grid_is_found():
    text = """\
labrun: 1
name: dome
devices: {gantry: gantry@1}
steps:
  - foreach: {p: "${{ grid(x=span(0 mm, 40 mm, 0.1 mm), y=span(0 mm, 40 mm, 0.1 mm)) }}"}
    key: ${{ p.index }}
    steps:
      - do: gantry.move_to
        with: {z: "${{ 1 mm + p.x * (p.x - 39 mm) / 380 mm }}"}
"""
    (problem,) = check_text(text, "dome.yaml").problems

    assert problem.code == "E207"
    assert problem.message.startswith("gantry.move_to.z: grid point 191 (19.1, 0.0) is outside z")


def test_an_item_for_which_the_step_is_left_out_is_not_outside():
    text = """\
labrun: 1
name: portions
devices: {pipette: pipette@1}
steps:
  - foreach: {v: "${{ [0 uL, 5 uL, 2000 uL] }}"}
    steps:
      - {do: pipette.dispense, with: {volume: "${{ v }}"}, when: "${{ v > 0 uL }}"}
"""
    (problem,) = check_text(text, "portions.yaml").problems

    assert (problem.code, "2000" in problem.message) == ("E207", True)
    assert check_text(text.replace(", 2000 uL", ""), "portions.yaml").problems == []
