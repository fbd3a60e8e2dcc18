"""The fast reader and the whole parser read the same; what the fast one cannot, it leaves."""

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.language.yaml_fast import read_fast
from labrun.engine.language.yaml_lines import Lines
from labrun.engine.language.yaml_node import DEEPEST, Node
from labrun.engine.language.yaml_pieces import Unusual
from labrun.engine.language.yaml_read import read_all_yaml

ROOT = Path(__file__).parents[3]
FILES = [*ROOT.glob("protocols/**/*.yaml"), *ROOT.glob("tests/engine/faulty/*.yaml")]


def everything(node: Node | None, lines: Lines, key: object = None) -> object:
    """A node as it is seen from outside: values, kinds, and places; an empty one has its key's."""
    if node is None:
        return None
    place = key if key and node.start == node.end else lines.span(node.start, node.end)
    if node.members is not None and node.keys is not None:
        places = {name: lines.span(*span) for name, span in node.keys.items()}
        inner = [
            (name, places[name], everything(member, lines, places[name]))
            for name, member in node.members.items()
        ]
    else:
        inner = [everything(item, lines) for item in node.items or []]
    return place, repr(node.value), node.plain, node.size, inner


def compare(text: str) -> bool:
    """True where the fast reader read the text; it must then be as the whole parser has it."""
    try:
        fast = read_fast(text)
    except Unusual:
        return False
    lines = Lines(text)
    slow, faults, whole = read_all_yaml(text, lines)

    assert whole and faults == []
    assert everything(fast, lines) == everything(slow, lines)
    return True


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_files_are_read_alike_with_any_line_ends(path):
    text = path.read_text(encoding="utf-8").removeprefix("\ufeff")

    assert compare(text) == compare(text.replace("\n", "\r\n"))


def test_what_people_write_is_read_fast():
    slow = [
        path.name
        for path in ROOT.glob("protocols/**/*.yaml")
        if not compare(path.read_text("utf-8"))
    ]

    assert slow == []


@pytest.mark.parametrize(
    "text",
    [
        "a: b\n  c\n\n  d\n", "a: |\n  b\n   c\n\n  d\n\n# e\nf: 1\n", "a: >-\n  b\n  c\n\n  d\nf: 1\n",
        "a: 'b\n  c'\n", 'a: "b\n\n  c"\n', r'a: "\n\x41\u00e9\"\/"', "a:\n- b\n- c: d\n  e: f\ng: 1\n",
        "- - a\n  - b\n-\n  - c\n", "---\na: 1\n", "# c\n--- # d\n\na: 1", "a: {b, c: 1, d: }\n",
        "a: {b: c\n  d, e: [1,\n # f\n 2,]}\n", "a: [1:30, x?y, a#b, -1, -x]\n", '{"a":1,"b":[]}\n',
        "null: 1\n010: 2\n'q': 3\n", "a b: c\n", "a:\nb: ''\n", "a: b:c\n", "a: b #c\n", "a: b#c\n",
    ],
)  # fmt: skip
def test_these_forms_are_read_fast_and_alike(text):
    assert compare(text)
    assert compare(text.replace("\n", "\r\n"))


@pytest.mark.parametrize(
    "text",
    [
        "a: &x 1", "a: *x", "a: !!str 1", "a:\t1", "%YAML 1.2\n---\na: 1", "a: 1\n---\nb: 2", "a: 1\n...\n",
        "? a\n: b", "a: 1\na: 2", "<<: 1", "a: 1\rb: 2", "a: .nan", "a: b: c", "a: ${{ x # y }}\n  z",
        "{a: ${{ b }}}", "a: {{ b }}", "a: x\u2028", "[a]: b", "a: |2\n   b\n", "a: |+\n  b\n\n", "a: 'b",
        "a: @b", "a: [b: c]", "a\n: b", "a: >\n  b\n   c\n", '"a\\n": 1', "- a\nb: 1", "a: 1\n  b: 2",
    ],
)  # fmt: skip
def test_what_is_out_of_the_ordinary_is_left_to_the_whole_parser(text):
    with pytest.raises(Unusual):
        read_fast(text)


def test_deep_nests_are_left_to_the_whole_parser():
    assert compare("a: " + "[" * (DEEPEST - 1) + "]" * (DEEPEST - 1))
    assert compare("- " * (DEEPEST - 1) + "a")
    with pytest.raises(Unusual):
        read_fast("- " * (DEEPEST + 1) + "a")


words = st.text(alphabet="ab1-:#,.{}[]'\"?é &*!|>$~_+<=% ", max_size=8)
values = st.one_of(
    words,
    words.map(lambda word: f'"{word}"'),
    words.map(lambda word: f"'{word}'"),
    st.sampled_from([
        "${{ a }}", "null", "010", "1e3", "a # c", "|\n    x\n     y\n\n    z\n", ">\n    x\n\n    z\n",
        "|-\n   x\n", "a\n   b", "a\n\n      b c", "'a\n  b'", '"a\\n\\u00e9"', "{a: 1, b: [x, y]}",
        "[a, {b: c}]", "[\n a,\n # c\n b,]", "{a\n b: c}", "<<", "- a", "- a: 1", '{"a":1}', "{a: }",
    ]),
)  # fmt: skip
before = st.sampled_from(
    ["a: ", "b: ", "- ", "- a: ", "- - ", "", "c:", "'k': ", "a b: ", "#", "-", "k:"]
)
line = st.builds(
    lambda indent, key, value, after: " " * indent + key + value + after,
    st.sampled_from([0, 0, 2, 2, 4, 4, 1, 3]), before, values, st.sampled_from(["", "", " # c", " ", "#x"]),
)  # fmt: skip


@settings(max_examples=1000, deadline=None)
@given(
    st.lists(line, max_size=7).map("\n".join),
    st.sampled_from(["", "\n", "\n\n", "\n  ", "\n# e"]),
    st.booleans(),
)
def test_lines_of_all_kinds_are_read_alike(text, end, windows):
    text += end
    compare(text.replace("\n", "\r\n") if windows else text)


@settings(max_examples=1000, deadline=None)
@given(st.text(alphabet="ab:{}[],-'\"#$? \n1", max_size=24))
def test_short_texts_of_all_kinds_are_read_alike(text):
    compare(text)
