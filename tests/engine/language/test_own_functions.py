"""Functions of one's own: read from their text, with the types and units of their annotations."""

import pytest

from labrun.engine.language.operators import OperatorFault
from labrun.engine.language.own_functions import FunctionFault, misfit, read_function
from labrun.engine.language.types import ANY, INTEGER, NUMBER, TEXT, Type, number
from labrun.schemas.quantity import quantity, quantity_text

TEXTS = """
from __future__ import annotations
import typing
from typing import Annotated

raise SystemExit("this file is never imported")

def area(
    widths: list[Annotated[float, "mm"]], height: Annotated[float, "mm"] = 1.0
) -> Annotated[float, "mm**2"]:
    return sum(widths) * height

def fit(
    x: list[float], y: "typing.Annotated[list[float], 'g']", *, degree: int = 1
) -> dict[str, float | None]: ...
def many(*values: float) -> float: ...
def each(values: list[float]) -> list[float]:
    yield 1
def untyped(x) -> float: ...
def silent(x: float): ...
def array(x: np.ndarray) -> float: ...
def odd(x: Annotated[float, "mmm"]) -> float: ...
def worded(x: Annotated[str, "mm"]) -> float: ...
def unnamed(x: float, /) -> float: ...
async def later(x: float) -> float: ...
def any_at_all(x: typing.Any) -> None: ...
"""


@pytest.fixture
def read(tmp_path):
    (tmp_path / "own.py").write_text(TEXTS)
    (tmp_path / "null.py").write_bytes(b"\0")
    (tmp_path / "torn.py").write_text("def f(:\n")

    def read(said):
        return read_function("f", said, tmp_path / "p.yaml", (tmp_path,))

    return read


def test_what_it_takes_and_gives_is_what_it_says(read):
    area, fit = read("./own.py:area"), read("own.py:fit")

    assert area.returns == number("mm**2")
    assert area.signature.parameters["widths"].annotation == Type("list", item=number("mm"))
    assert fit.signature.parameters["y"].annotation == Type("list", item=number("g"))
    assert fit.signature.parameters["degree"].annotation == INTEGER
    assert fit.returns == Type("map", rest=NUMBER)
    assert read("own.py:any_at_all").signature.parameters["x"].annotation == ANY


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ("own.py", "not a function in a file"), ("own.txt:area", "not a function"),
        ("on.py:area", "did you mean own.py"),
        ("../own.py:area", "outside the protocol's folder"), ("torn.py:f", "torn.py, line 1 is not Python"),
        ("own.py:aera", "did you mean area"), ("own.py:many", "any number"), ("own.py:each", "generator"),
        ("own.py:untyped", "untyped, x: there is no annotation"), ("own.py:silent", "what it returns"),
        ("own.py:array", "no values of the type np.ndarray"), ("own.py:odd", "'mmm' is not a unit"),
        ("own.py:worded", "text has no unit"), ("own.py:unnamed", "without their names"),
        ("own.py:later", "later is `async`"), ("null.py:f", "null.py is not Python|null.py cannot be read"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_told_in_a_sentence(read, said, words):
    with pytest.raises(FunctionFault, match=words.replace("?", r"\?")):
        read(said)


def test_arguments_are_plain_numbers_in_the_units_of_the_annotations(read):
    area = read("own.py:area")

    assert area.given([[quantity(1, "cm"), 2.0, None]], {"height": quantity(3, "um")}) == {
        "widths": [10, 2.0, None], "height": 0.003,
    }  # fmt: skip
    assert quantity_text(area.result(6)) == "6 mm²"


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (["a"], "'a', not a list"), ([[quantity(1, "s")]], "is a time"), ([[True]], "not a length"),
        ([], "missing a required argument: 'widths'"), ([{"a": 1}], "not a list"),
    ],
)  # fmt: skip
def test_arguments_that_do_not_fit_are_refused(read, args, words):
    with pytest.raises(OperatorFault, match=words):
        read("own.py:area").given(args, {})


@pytest.mark.parametrize("gave", ["a", float("nan"), [1.0], True, {}])
def test_a_result_that_it_does_not_say_is_refused(read, gave):
    with pytest.raises(OperatorFault, match=r"^f gave"):
        read("own.py:area").result(gave)


def test_types_are_compared_before_the_run():
    lengths = Type("list", item=number("mm"))

    assert misfit(Type("list", item=number("um")), lengths) == ""
    assert misfit(Type("list", item=NUMBER), lengths) == ""
    assert "a time (s), not a length" in misfit(Type("list", item=number("s")), lengths)
    assert "without a unit" in misfit(number("mm"), NUMBER)
    assert "text, not" in misfit(TEXT, NUMBER)
    assert misfit(ANY, NUMBER) == ""
