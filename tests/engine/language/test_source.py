"""Files are read as data with places, and nothing that a file holds takes the reader down."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.language.source import LARGEST, parse_source, read_source


def read(text: str):
    return parse_source(text, Path("p.yaml"), "p.yaml")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("no", "no"), ("on", "on"), ("1:30", "1:30"), ("010", 10), ("0o10", 8), ("0x1F", 31),
        ("1_000", "1_000"), ("1e3", 1000.0), (".5", 0.5), ("5.", 5.0), ("+3", 3), ("-0", 0),
        ("~", None), ("Null", None), ("nULL", "nULL"), ("True", True), ("yes", "yes"),
        ("2026-11-21", "2026-11-21"), ("'3'", "3"), ('"true"', "true"), ("!!str 3", "3"),
        ("!!float 3", 3.0), ("12e", "12e"), ("0x", "0x"), ("<<", "<<"), ("=", "="),
    ],
)  # fmt: skip
def test_scalars_mean_what_yaml_1_2_says(text, value):
    source, problems = read(f"a: {text}\n")

    assert problems == []
    assert source is not None and source.data == {"a": value}
    assert type(source.data["a"]) is type(value)


def test_places_of_values_and_keys_are_counted_as_editors_count():
    source, _ = read("first: 1\r\nµm: {x: 2,\r\n  second: [a, 'b c']}\r\n")

    assert source is not None
    assert source.place(("µm", "x")) == (2, 9, 1)
    assert source.place(("µm", "second", 1)) == (3, 15, 5)
    assert source.place(("µm", "second"), key=True) == (3, 3, 6)
    assert source.place(("µm", "third")) == source.place(("µm",))


def test_a_value_over_several_lines_is_underlined_on_its_first():
    source, _ = read("a:\n  text: |\n    one\n    two\nb: 1\n")

    assert source is not None
    assert source.place(("a", "text")) == (2, 9, 1)
    assert source.place(("b",)) == (5, 4, 1)


def test_an_alias_repeats_its_anchor():
    source, problems = read("a: &x {y: 1}\nb: *x\n")

    assert problems == []
    assert source is not None and source.data["b"] == {"y": 1}


def test_json_is_read_as_well():
    source, problems = read('{"labrun": 1, "steps": [{"do": "gantry.home"}], "x": "\\u00e9"}')

    assert problems == []
    assert source is not None and source.data["x"] == "é"


def test_a_byte_order_mark_moves_nothing():
    source, problems = read("\ufefflabrun: 1\n")

    assert problems == []
    assert source is not None and source.place(("labrun",), key=True) == (1, 1, 6)


@pytest.mark.parametrize("content", [b"", b"# only a comment\n", b"---\n"])
def test_an_empty_file_is_told(content, tmp_path):
    path = tmp_path / "empty.yaml"
    path.write_bytes(content)
    source, problems = read_source(path)

    assert source is None
    assert [p.code for p in problems] == ["E100"]


def test_files_that_cannot_be_read_are_problems(tmp_path):
    latin = tmp_path / "latin.yaml"
    latin.write_bytes(b"a: 1\nname: caf\xe9\n")
    large = tmp_path / "large.yaml"
    with large.open("wb") as file:
        file.truncate(LARGEST + 1)
    (tmp_path / "there.yaml").write_text("a: 1")
    told = {
        name: read_source(tmp_path / name)[1][0]
        for name in (".", "their.yaml", "latin.yaml", "large.yaml", "null\0.yaml")
    }

    assert told["."].message == "this is a folder, not a file"
    assert told["their.yaml"].hint == "did you mean there.yaml?"
    assert (told["latin.yaml"].line, told["latin.yaml"].column) == (2, 10)
    assert told["large.yaml"].code == "E108"
    assert told["null\0.yaml"].code == "E100"


@pytest.mark.parametrize(
    "text",
    [
        "[" * 10_000, "{a: " * 10_000, "- " * 10_000, "a: " + "[" * 5000 + "]" * 5000,
        "\n".join("  " * n + "a:" for n in range(2000)),
    ],
    ids=["lists", "maps", "items", "closed", "indented"],
)  # fmt: skip
def test_a_deep_nest_is_a_problem_not_a_crash(text):
    source, problems = read(text)

    assert source is None
    assert problems[0].code in ("E101", "E108")


@settings(max_examples=300, deadline=None)
@given(st.text(alphabet="ab:{}[],-&*!|>'\"#%@`\\ \n\t\r0.$?~\u2028\x85é", max_size=60))
def test_any_text_is_read_or_refused_with_a_place(text):
    source, problems = read(text)

    assert source is not None or problems
    for problem in problems:
        assert problem.line <= text.count("\n") + text.count("\r") + 1
