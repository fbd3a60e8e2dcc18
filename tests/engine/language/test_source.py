"""Files are read as data with places, and no file content crashes the reader."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.language.source import parse_source, read_source


def read(text: str):
    return parse_source(text, Path("p.yaml"), "p.yaml")


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("no", "no"), ("on", "on"), ("1:30", "1:30"), ("0o10", 8), ("0x1F", 31),
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


def test_places_count_windows_line_ends_and_old_mac_ones():
    windows, _ = read("a: 1\r\nb: [x,\r\n  y]\r\n")
    mac, _ = read("a: 1\rb: [x,\r  y]\r")

    assert windows is not None and mac is not None
    assert windows.data == mac.data == {"a": 1, "b": ["x", "y"]}
    assert windows.place(("b", 1)) == mac.place(("b", 1)) == (3, 3, 1)


def test_a_second_key_names_the_line_of_the_first():
    _, problems = read("a: 1\nb: 2\na: 3\n")

    assert (problems[0].code, problems[0].line) == ("E102", 3)
    assert "line 1" in problems[0].message


def test_merge_keys_give_what_a_mapping_has_not_itself_with_its_place():
    text = "base: &base {x: 1, y: 2}\nmore: &more {y: 3, z: 4}\na:\n  y: 5\n  <<: [*base, *more]\n"
    source, problems = read(text)

    assert problems == []
    assert source is not None
    assert source.data["a"] == {"y": 5, "x": 1, "z": 4}
    assert source.place(("a", "y")) == (4, 6, 1)
    assert source.place(("a", "z"), key=True) == (2, 20, 1)


def test_a_quoted_merge_key_is_a_key():
    source, problems = read("a: {'<<': 1}\n")

    assert problems == []
    assert source is not None and source.data == {"a": {"<<": 1}}


def test_merges_that_blow_up_are_refused():
    bomb = "a0: &a0 {k: 1}\n" + "".join(
        f"a{n}: &a{n} {{l: [{', '.join([f'*a{n - 1}'] * 9)}], <<: *a{n - 1}}}\n"
        for n in range(1, 12)
    )
    _, problems = read(bomb)

    assert [p.code for p in problems] == ["E108"]


def test_a_pair_of_surrogates_is_one_character():
    source, problems = read('a: "\\ud83d\\ude00"\n')

    assert problems == []
    assert source is not None and source.data == {"a": "\U0001f600"}


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
