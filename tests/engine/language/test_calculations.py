"""Functions that calculate: with units, null and temperatures; a sentence where there is no result."""

import math
import statistics

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from labrun.engine.language.expression import Expression, ExpressionError
from labrun.engine.language.least_squares import least_squares
from labrun.schemas.quantity import is_quantity, quantity_text

NAMES = {"spots": [{"area": 4.0}, {"area": None}, {"area": 1.0}], "i": 7, "none": None}


def value(text, **names):
    found = Expression(text).evaluate({**NAMES, **names})
    return quantity_text(found) if is_quantity(found) else found


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("sum([1 mm, 2 cm, 0])", "21 mm"), ("sum([])", 0), ("sum([1, 2.5])", 3.5),
        ("mean([1 mm, 3 mm])", "2 mm"), ("median([3, 1, 2])", 2), ("stdev([1 s, 3 s])", "1.41421356237 s"),
        ("mean([s.area for s in spots])", 2.5), ("sqrt(4 mm * 1 mm)", "2 mm"), ("sqrt(none)", None),
        ("log10(1 m / 1 cm)", 2.0), ("exp(0)", 1.0), ("log(exp(2))", 2.0), ("sin(90 deg)", 1.0),
        ("atan2(1 mm, 1 mm)", f"{math.pi / 4:.12g} rad"), ("abs(-3 K)", "3 K"), ("abs(-2)", 2),
        ("floor(-1.5)", -2), ("ceil(3.2 mm)", "4 mm"), ("int(3.9)", 3), ("int('12')", 12),
        ("sorted([3, 1, 2])", [1, 2, 3]), ("sorted([s.area for s in spots])", [1.0, 4.0, None]),
        ("sorted(['b', 'a'])", ["a", "b"]), ("sorted([1 cm, 2 mm])[0]", "2 mm"), ("reversed([1, 2])", [2, 1]),
        ("zip([1, 2], [3, 4])", [[1, 3], [2, 4]]), ("enumerate(['a'], 1)", [[1, "a"]]),
        ("linspace(0 mm, 1 cm, 3)[1]", "5 mm"), ("linspace(0, 1, 4)[1]", 0.333333333333),
        ("polyfit([0 s, 1 s, 2 s], [1 mm, 3 mm, 5 mm])[0]", "2 mm/s"),
        ("round(polyfit([0, 1, 2], [1, 3, 7], 2)[1], 9)", 1), ("interp(15 mm, [1 cm, 2 cm], [0, 10])", 5.0),
        ("interp(none, [1, 2], [1, 2])", None),
    ],
)  # fmt: skip
def test_a_function_gives_what_it_says(text, expected):
    assert value(text) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("20 degC - 15 degC", "5 K"), ("20 degC + 5 K", "25 °C"), ("5 K + 20 degC", "25 °C"),
        ("20 degC - 5 K", "15 °C"), ("68 degF - 50 degF", "10 K"), ("68 degF + 5 K", "77 °F"),
        ("abs(19.5 degC - 20 degC) < 1 K", True), ("mean([20 degC, 30 degC])", "25 °C"),
        ("stdev([20 degC, 30 degC])", "7.07106781187 K"), ("linspace(20 degC, 80 degC, 3)[1]", "50 °C"),
        ("span(20 degC, 80 degC, 20 degC)[1]", "40 °C"), ("span(20 degC, 80 degC, 15 K)[4]", "80 °C"),
        ("len(span(20 degC, 80 degC, 15 K))", 5),
        ("-20 degC", "-20 °C"), ("15 degC - -20 degC", "35 K"), ("-40 degC < -20 degC", True),
        ("polyfit([0 s, 1 s], [20 degC, 22 degC])[0]", "2 K/s"), ("max(20 degC, 290 K)", "20 °C"),
    ],
)  # fmt: skip
def test_differences_of_temperatures_are_in_kelvin_and_their_sums_are_places_on_the_scale(
    text, expected
):
    assert value(text) == expected


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("20 degC + 20 degC", "add a difference in K"), ("300 K - 20 degC", "both in K"),
        ("2 * 20 degC", "kelvin"), ("sqrt(-1)", "no real root"), ("log(0)", "log of 0 does not exist"),
        ("log(3 mm)", "divide by one first"), ("exp(1000)", "too large"), ("sin(1 mm)", "not an angle"),
        ("mean([])", "at least 1"), ("stdev([1])", "at least 2"), ("sum(3)", "takes a list"),
        ("mean(['a'])", "not a number"), ("mean([1 mm, 2 s])", "used together in mean"),
        ("int('1.5')", "whole"),
        ("zip([1], [2, 3])", "1 and 2 items"), ("linspace(0, 1, 0)", "whole number from 1"),
        ("interp(3, [1, 2], [1, 2])", "outside 1 to 2"),
        ("interp(1, [2, 1], [1, 2])", "larger than the last"),
        ("polyfit([1, 1], [1, 2])", "2 places"), ("polyfit([20 degC, 30 degC], [1, 2])", "give it in K"),
        ("[k for k in 3]", "not a list"), ("[k for k, m in [1]]", "not a list"),
        ("[0 for a in range(1000) for b in range(1000)]", "100,000 turns"),
        ("[params for params in spots]", "already means"), ("50 mµ", "did you mean µm?"),
    ],
)  # fmt: skip
def test_what_has_no_result_is_told_in_a_sentence(text, words):
    with pytest.raises(ExpressionError, match=words.replace("?", r"\?")):
        value(text)


def test_a_comprehension_has_names_of_its_own_and_uses_those_around_it():
    expression = Expression("[i * k for i in range(3) for k in [i] if k > 1] + [i]")

    assert expression.names == {"i"}  # the last one, which stands outside
    assert expression.evaluate(NAMES) == [4, 7]


@given(
    st.lists(st.tuples(st.integers(-50, 50), st.floats(-9, 9)), min_size=6, max_size=40),
    st.integers(0, 3), st.sampled_from([0, 30]),
)  # fmt: skip
def test_no_polynomial_fits_better_than_the_one_that_is_found(points, degree, away):
    xs, ys = zip(*((away + x / 10, y) for x, y in points), strict=True)
    assume(len(set(xs)) > degree)
    ours, theirs = least_squares(xs, ys, degree), np.polyfit(xs, ys, degree)
    left = [math.fsum((np.polyval(one, xs) - ys) ** 2) for one in (ours, theirs)]

    assert left[0] <= left[1] * (1 + 1e-6) + 1e-6


@given(st.lists(st.floats(-1e6, 1e6), min_size=2, max_size=30))
def test_statistics_with_a_unit_are_those_of_the_bare_numbers(numbers):
    unit = [f"{number!r} mm" for number in numbers]
    for name, bare in (
        ("mean", statistics.fmean),
        ("median", statistics.median),
        ("stdev", statistics.stdev),
    ):
        found = Expression(f"{name}([{', '.join(unit)}])".replace("+", "")).evaluate({})
        assert found.to("mm").magnitude == pytest.approx(bare(numbers), rel=1e-9, abs=1e-9)
