"""The example with anything in it missing, renamed or of another type: problems, never a traceback."""

import copy
import io
import json
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.check import check_text
from labrun.engine.language.source import read_source
from labrun.engine.print_problems import print_problems

EXAMPLE = Path(__file__).parent / "examples" / "libs_grid_scan.yaml"
SOURCE = read_source(EXAMPLE)[0]
assert SOURCE is not None
DATA: Any = SOURCE.data
OTHERS: list[Any] = [
    None,
    True,
    -1,
    1.5,
    "",
    "text",
    "${{ x",
    "${{ steps }}",
    [],
    [[]],
    {},
    {"a": {"b": 1}},
]


def places(data: Any, path: tuple[Any, ...] = ()) -> list[tuple[Any, ...]]:
    inner = (
        data.items()
        if isinstance(data, dict)
        else enumerate(data)
        if isinstance(data, list)
        else ()
    )
    return [path] * bool(path) + [p for key, value in inner for p in places(value, (*path, key))]


def holder(data: Any, path: tuple[Any, ...]) -> Any:
    for part in path[:-1]:
        data = data[part]
    return data


def checked(data: Any) -> Any:
    result = check_text(json.dumps(data), "mutant.json", needed=True)
    for problem in result.problems:
        assert problem.message and problem.code
    return result


@pytest.mark.parametrize("path", places(DATA), ids=lambda path: ".".join(map(str, path)))
def test_any_part_may_be_deleted_renamed_or_of_another_type(path):
    deleted = copy.deepcopy(DATA)
    del holder(deleted, path)[path[-1]]
    checked(deleted)
    if isinstance(path[-1], str):
        renamed = copy.deepcopy(DATA)
        around = holder(renamed, path)
        around[path[-1] + "x"] = around.pop(path[-1])
        checked(renamed)
    for other in OTHERS:
        retyped = copy.deepcopy(DATA)
        holder(retyped, path)[path[-1]] = other
        checked(retyped)


@settings(max_examples=150, deadline=None)
@given(st.text(max_size=200))
def test_any_text_is_checked_without_a_traceback(text):
    assert check_text(text, "any.yaml").problems


@settings(max_examples=200, deadline=None)
@given(st.data())
def test_the_example_with_pieces_of_itself_in_other_places_is_checked(data):
    text = EXAMPLE.read_text(encoding="utf-8")
    start, end, there = (data.draw(st.integers(0, len(text))) for _ in range(3))
    mixed = text[:there] + text[min(start, end) : max(start, end)][:120] + text[there + 20 :]
    result = check_text(mixed, "mixed.yaml")
    print_problems(result.problems, file=io.StringIO())

    assert result.ok == (not any(p.severity == "error" for p in result.problems))
