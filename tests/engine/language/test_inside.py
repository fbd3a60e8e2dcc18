"""Points inside an outline: with units, with a margin, at the edge, and what is rejected."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.language.expression import ExpressionError, expression
from labrun.engine.language.infer import infer
from labrun.engine.language.inside import inside
from labrun.engine.language.types import NUMBER, TEXT, Type, fields, number
from labrun.schemas.quantity import parse_quantity

LENGTH = number("mm")


def mm(*places):
    return [{"x": parse_quantity(f"{x} mm"), "y": parse_quantity(f"{y} mm")} for x, y in places]


def bare(*places):
    return [{"x": x, "y": y} for x, y in places]


SQUARE = bare((0, 0), (4, 0), (4, 4), (0, 4))
HOOK = bare((0, 0), (6, 0), (6, 2), (2, 2), (2, 6), (0, 6))  # an L: its inner corner is at 2, 2


def found(text, **names):
    return [(float(p["x"]), float(p["y"])) for p in expression(text).evaluate(names)]


def test_points_keep_their_order_and_all_their_fields():
    points = [{"x": x, "y": 1, "index": x} for x in (5, 3, 1, -1)]

    assert inside(points, SQUARE) == [points[1], points[2]]


def test_a_grid_loses_what_lies_outside_an_outline_that_is_not_convex():
    text = "inside(grid(x=span(1, 5, 2), y=span(1, 5, 2)), outline)"

    assert found(text, outline=HOOK) == [(1, 1), (3, 1), (5, 1), (1, 3), (1, 5)]


def test_the_edge_and_the_corners_are_inside():
    points = bare((0, 0), (4, 2), (2, 4), (4, 4), (4.001, 2))

    assert inside(points, SQUARE) == points[:4]


def test_a_margin_keeps_off_the_edge_also_round_an_inner_corner():
    points = bare((1, 1), (0.9, 1), (1.5, 1.5), (1.2, 1.2), (3, 1))

    assert inside(points, HOOK, 1) == bare((1, 1), (1.2, 1.2), (3, 1))


def test_units_are_those_of_the_outline():
    outline = mm((0, 0), (10, 0), (10, 10), (0, 10))
    points = [{"x": parse_quantity("0.5 cm"), "y": parse_quantity("9500 um")}]
    names = {"outline": outline, "points": points}

    assert expression("inside(points, outline, 0.5 mm)").evaluate(names) == points
    assert expression("inside(points, outline, 600 um)").evaluate(names) == []


def test_nothing_in_nothing_out():
    assert inside(None, SQUARE) is None
    assert inside(bare((1, 1)), None) is None
    assert inside([], SQUARE) == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("inside(points, points[:2])", "three corners or more, this one has 2"),
        ("inside(3, points)", "the points must be a list or a grid"),
        ("inside(points, 'square')", "the outline must be a list or a grid"),
        ("inside([1, 2], points)", "the points must have an x and a y"),
        ("inside(points, points, 1 mm)", "margin is 1 mm; either all have units or none"),
        ("inside(points, points, -1)", "the margin must not be negative"),
        ("inside(points, outline, 1 s)", "margin"),
        ("inside(outline, points)", "x is 1 mm; either all have units"),
    ],
)
def test_what_cannot_be_is_said(text, words):
    names = {"points": SQUARE, "outline": mm((1, 1), (10, 0), (10, 10))}
    with pytest.raises(ExpressionError, match=words):
        expression(text).evaluate(names)


class Known:
    """Names whose types are known, as in a protocol."""

    def __init__(self, **types):
        self.types = types

    def name(self, name):
        return self.types[name]


def told(text, **types):
    kind, faults = infer(expression(text), Known(**types))
    return kind, [(fault.code, fault.message) for fault in faults]


def test_the_checker_knows_what_comes_out():
    points = Type("list", item=fields(x=LENGTH, y=LENGTH))

    assert told("inside(p, o, 1 um)", p=points, o=points) == (points, [])
    assert told("inside(p, o)", p=points, o=points) == (points, [])
    assert told("inside(p, o, 0)", p=points, o=points) == (points, [])


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("inside(p)", "E307", "outline is missing"),
        ("inside(p, t)", "E308", "outline is text, not a list"),
        ("inside(n, p)", "E308", "points is a plain number, not a list"),
        ("inside(p, p, 1 s)", "E308", "margin is a time (s), and x of the points is a length (mm)"),
        ("inside(p, p, 1)", "E308", "margin is a whole number"),
        ("inside(p, p, t)", "E308", "margin is text"),
        ("1 + sqrt(4) - sqrt(t)", "E308", "sqrt(t): sqrt takes a number, not text"),
        ("sin(n) + sin(2 mm)", "E308", "sin(2 mm): sin takes an angle, not a length (mm)"),
    ],
)
def test_the_checker_finds_what_cannot_work(text, code, words):
    points = Type("list", item=fields(x=LENGTH, y=LENGTH))
    _, ((found_code, message),) = told(text, p=points, t=TEXT, n=NUMBER)

    assert found_code == code
    assert words in message


@settings(max_examples=60)
@given(
    st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=1, max_size=30),
    st.integers(1, 8), st.integers(1, 8), st.integers(0, 3),
)  # fmt: skip
def test_in_a_rectangle_it_is_comparing(places, width, height, margin):
    outline = bare((0, 0), (width, 0), (width, height), (0, height))
    kept = [
        (x, y) for x, y in places
        if margin <= x <= width - margin and margin <= y <= height - margin
    ]  # fmt: skip

    assert inside(bare(*places), outline, margin) == bare(*kept)
