"""Expressions compute with units, reject side effects, and fail with a clear message."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.language.expression import Expression, ExpressionError, expression, told_roles
from labrun.engine.language.value import value_of
from labrun.schemas.quantity import parse_quantity, quantity_text

NAMES = {
    "params": {"pitch": parse_quantity("0.2 mm"), "n": 3, "name": "core"},
    "steps": {"shoot": {"shot_id": "s1", "areas": {"Li": 4.0}}, "skipped": None},
    "point": {"x": parse_quantity("1 mm"), "ix": 2, "tags": ["a", "b"]},
}


def shown(value: object) -> object:
    return quantity_text(value) if hasattr(value, "units") else value


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("params.n + 1", 4), ("params.pitch + 0.1 mm", "0.3 mm"), ("params.pitch + 100 um", "0.3 mm"),
        ("params.pitch * 3", "0.6 mm"), ("10 mm/s * 2 s", "20 mm"), ("4 mm / 200 um", 20.0),
        ("30 deg / 2", "15 deg"), ("90 deg / 45 deg", 2.0),
        ("params.pitch > 0", True), ("0 < params.pitch < 1 cm", True), ("1 mm == 1000 um", True),
        ("1 mm == 1 s", False), ("-params.pitch", "-0.2 mm"), ("point.tags[1]", "b"),
        ("'a' in point.tags", True), ("len(point.tags)", 2), ("max(1 mm, params.pitch)", "1 mm"),
        ("min([3, 1, 2])", 1), ("round(2.345, 1)", 2.3), ("round(1.26 mm, 1)", "1.3 mm"),
        ("format(params.pitch, '.3f')", "0.200 mm"), ("'x' if params.n > 2 else 'y'", "x"),
        ("steps.skipped.anything", None), ("steps.skipped.a + 1", None), ("steps.shoot.areas.K", None),
        ("steps.skipped.a > 3", None), ("steps.shoot['shot_id']", "s1"), ("true and not false", True),
        ("null == None", True), ("7 // 2", 3), ("7 mm % 2 mm", "1 mm"), ("50 % 3", 2),
        ("list(1)" if False else "[1, 2][-1]", 2), ("5 in [5, 6]", True), ("2 ** 10", 1024),
        ("steps.shoot.areas.Li / 2", 2.0), ("'a' + 'b'", "ab"), ("range(5)[2]", 2),
    ],
)  # fmt: skip
def test_what_expressions_compute(text, value):
    assert shown(expression(text).evaluate(NAMES)) == value


@pytest.mark.parametrize(
    "text",
    [
        "", "1 +", "import os", "__import__('os')", "params.__class__", "(1).__class__", "lambda: 1",
        "f'{1}'", "{'a': 1}", "x := 1", "open('a')", "params.name.upper()",
        "x = 1", "a && b", "1; 2", "print(1)", "*point.tags", "min(*point.tags)", "min(**params)",
        "b'1'", "...", "1j", "3 foo", "1 << 2", "~1", "await x", "(" * 300,
        "-" * 1000 + "1", "1" * 5000, "_quantity.__class__", "1e999", "${{ 1 }}", "\0", "a b",
    ],
)  # fmt: skip
def test_what_acts_or_cannot_be_read_is_refused_when_it_is_read(text):
    with pytest.raises(ExpressionError):
        Expression(text)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("span(params.x0; 3 mm, 1 mm)", "at `;`"), ("3 mm 4", "at `4`"),
        ("a ? b : c", "a if condition else b"),
        ("params.pitch +", "ends too early"), ("1 if", "ends too early"), ("(1", "never closed"),
        ("p.x },${{ p.y", "a } is missing"), ("1 + ${{ p.y }", "within an expression"),
    ],
)  # fmt: skip
def test_where_an_expression_cannot_be_read_on_is_told(text, says):
    with pytest.raises(ExpressionError) as told:
        Expression(text)

    assert says in str(told.value)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1 / 0", "divided by zero"), ("params.pich", "did you mean pitch"), ("nobody", "no name nobody"),
        ("params.pitch + 1", "no unit"), ("params.pitch + 1 s", "a length"), ("9 ** 9 ** 9", "too large"),
        ("10 ** 250 * 10 ** 250", "too large"), ("1e400 mm", "too large"),
        ("point.tags[7]", "no item 7"), ("params.n.x", "no field x"), ("'a' * 1000000000", "multiplied"),
        ("span(0, 1, 0.3)", "0.9"), ("span(0, 1, 0)", "never reaches the end"), ("len(3)", "no length"),
        ("grid(x=3, y=4)", "span or a list"), ("format(1, '999999999d')", "not a format"),
        ("round('a')", "not a number"), ("1e308 * 10", "finite"), ("20 degC + 5 degC", "a difference in K"),
        ("params.name < 3", "compared"), ("range(10 ** 12)", "more than"), ("span()", "missing 3"),
        ("(0 - 8) ** 0.5", "no real power"), ("'a' in 3", "no items to search"), ("params[0]", "no field 0"),
    ],
)  # fmt: skip
def test_what_cannot_be_computed_fails_with_a_sentence(text, says):
    with pytest.raises(ExpressionError, match=says):
        expression(text).evaluate(NAMES)


def test_an_expression_knows_the_names_it_asks_for():
    assert expression("grid(x=params.a, y=point.x) if true else run.id").names == {
        "params", "point", "run",
    }  # fmt: skip


def test_a_whole_scalar_keeps_its_type_and_text_inserts_quantities():
    whole = value_of("${{ params.pitch }}").evaluate(NAMES)
    text = value_of("at ${{ params.pitch }}, ${{ point.ix }}, ${{ steps.skipped.x }}").evaluate(
        NAMES
    )
    braces = value_of("${{ '}}' }}").evaluate(NAMES)
    deep = value_of({"a": ["${{ params.n }}", 1], "b": "plain"})

    assert shown(whole) == "0.2 mm" and not isinstance(whole, str)
    assert text == "at 0.2 mm, 2, null"
    assert braces == "}}"
    assert deep.evaluate(NAMES) == {"a": [3, 1], "b": "plain"}
    assert not deep.constant and value_of({"a": [1, "x"]}).constant


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet="ab1.+-*/%()[]<>=!,' \"mprsty_{}$\n", max_size=40))
def test_any_text_between_braces_is_a_value_or_an_error_with_a_sentence(text):
    try:
        value_of(f"${{{{ {text} }}}}").evaluate(NAMES)
    except ExpressionError as fault:
        assert str(fault)


def test_a_step_called_as_a_word_of_python_is_told_as_that():
    with pytest.raises(ExpressionError, match="try is a word of expressions themselves; choose"):
        Expression("sharps + [steps.try.sharpness]")


@pytest.mark.parametrize("text", ["1 << 2", "1 >> 2", "1 | 2", "1 ^ 2", "1 & 2", "~ 1", "1 @ 2"])
def test_an_operator_that_is_not_one_is_told_as_it_was_written(text):
    (sign,) = set(text) - set("12 ")

    with pytest.raises(ExpressionError, match=f"`{re.escape(sign)}+` is not allowed"):
        expression(text)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("status.balance.mass", {"balance"}),
        ("status['balance'].mass", {"balance"}),
        ("status[params.role].mass", {"balance", "floor"}),
        ("len(status)", {"balance", "floor"}),
        ("status.floor.wet and status", {"balance", "floor"}),
        ("params.balance", set()),
    ],
)
def test_an_expression_knows_whose_status_it_reads(text, told):
    assert told_roles(expression(text), ["balance", "floor"]) == told
