"""Parameters: from the command line by type, or the default, always in the declared unit."""

from pathlib import Path
from typing import Any

import pytest

from labrun.engine.language.source import parse_source
from labrun.engine.params.params import read_params
from labrun.schemas.protocol import Param
from labrun.schemas.quantity import is_quantity, parse_quantity, quantity_text

DECLARED: dict[str, dict[str, Any]] = {
    "pitch": {
        "type": "quantity",
        "unit": "mm",
        "minimum": "10 um",
        "maximum": 5,
        "default": "0.2 mm",
    },
    "n": {"type": "integer", "minimum": 1, "default": 3},
    "ratio": {"type": "number", "default": 0.5},
    "sample": {"type": "string", "pattern": "^[a-z]+$", "default": "core"},
    "deep": {"type": "boolean", "default": False},
    "gas": {"type": "string", "enum": ["argon", "helium"], "default": "argon"},
    "holes": {"type": "array", "items": {"type": "number", "unit": "mm"}, "default": ["1 cm"]},
    "needed": {"type": "string"},
}


def take(given: dict[str, Any], *, needed: bool = False):
    source = parse_source(
        "params: {" + ", ".join(f"{n}: 1" for n in DECLARED) + "}\n", Path("p"), "p"
    )[0]
    assert source is not None
    declared = {name: Param.model_validate(data) for name, data in DECLARED.items()}
    return read_params(declared, given, source, needed=needed)


@pytest.mark.parametrize(
    ("pattern", "items"), [("^(a+)+$", None), (None, {"type": "string", "pattern": "^(a|aa)+$"})]
)
def test_no_pattern_takes_for_ever(pattern, items):
    source = parse_source("params: {a: 1}\n", Path("p"), "p")[0]
    assert source is not None
    kind = "string" if items is None else "array"
    param = Param.model_validate({"type": kind, "pattern": pattern, "items": items})
    text = "a" * 5000 + "!"

    _, problems = read_params(
        {"a": param}, {"a": text if items is None else [text]}, source, needed=True
    )

    assert [problem.code for problem in problems] == ["E222" if items is None else "E221"]


def test_a_pattern_that_python_has_doubts_about_is_a_pattern_all_the_same():
    source = parse_source("params: {a: 1}\n", Path("p"), "p")[0]
    assert source is not None
    declared = {"a": Param.model_validate({"type": "string", "pattern": "^[[a-z]+$"})}

    assert read_params(declared, {"a": "ab"}, source, needed=True)[0] == {"a": "ab"}


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("pitch", "100 um", "0.1 mm"), ("pitch", "3", "3 mm"), ("pitch", parse_quantity("1 mm"), "1 mm"),
        ("n", "12", 12), ("ratio", "1e-3", 0.001), ("ratio", "2", 2), ("sample", "abc", "abc"),
        ("deep", "yes", True), ("deep", "False", False), ("gas", "helium", "helium"),
        ("holes", "1, 2 mm", ["1 mm", "2 mm"]), ("holes", "[0.5]", ["0.5 mm"]), ("holes", [3], ["3 mm"]),
    ],
)  # fmt: skip
def test_texts_are_read_by_the_parameters_type(name, text, value):
    values, problems = take({name: text})
    found = values[name]
    shown = [quantity_text(i) for i in found] if isinstance(found, list) else found

    assert [p.code for p in problems] == ["W223"]
    assert (quantity_text(shown) if is_quantity(shown) else shown) == value


@pytest.mark.parametrize(
    ("name", "text", "code", "says"),
    [
        ("pitch", "2 s", "E221", "2 s is a time, wanted is a length (mm)"),
        ("pitch", "fine", "E221", "not a number with a unit"), ("pitch", "nan", "E221", "a length"),
        ("pitch", "1 um", "E222", "below the minimum 0.01 mm"), ("pitch", "6", "E222", "above the maximum"),
        ("n", "1.5", "E221", "a whole number"), ("n", "0", "E222", "below the minimum 1"),
        ("ratio", "half", "E221", "a number"), ("ratio", "inf", "E221", "a number"),
        ("sample", "A", "E222", "pattern"), ("deep", "maybe", "E221", "true or false"),
        ("gas", "heliun", "E222", "did you mean helium?"), ("holes", "1 s", "E221", "a time"),
        ("holes", "[", "E221", "not a list"), ("pich", "1 mm", "E220", "did you mean pitch?"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_told_of_the_option(name, text, code, says):
    problems = [p for p in take({name: text})[1] if p.code != "W223"]

    assert [(p.file, p.code) for p in problems] == [("-p", code)]
    assert says in problems[0].message


def test_a_parameter_without_a_value_is_an_error_for_a_run_and_a_warning_for_a_check():
    assert [(p.code, p.severity) for p in take({}, needed=True)[1]] == [("E223", "error")]
    assert [(p.code, p.severity) for p in take({})[1]] == [("W223", "warning")]
    assert take({"needed": ""})[1] == []
