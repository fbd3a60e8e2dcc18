"""libyaml and ruamel.yaml read the same; libyaml leaves what it might read differently."""

from pathlib import Path

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.language.source import parse_source
from labrun.engine.language.yaml_libyaml import Unlike, read_by_libyaml
from labrun.engine.language.yaml_lines import Lines
from labrun.engine.language.yaml_node import DEEPEST, Node, YamlFault
from labrun.engine.language.yaml_read import Reading, read_by_ruamel
from labrun.engine.language.yaml_traps import traps

ROOT = Path(__file__).parents[3]
SHIPPED = [*ROOT.glob("protocols/**/*.yaml"), *ROOT.glob("schemas/devices/*.yaml")]
FILES = [*SHIPPED, *ROOT.glob("tests/engine/faulty/**/*.yaml")]


def everything(node: Node | None, seen: dict[int, int], key: object = None) -> object:
    """A node with all its content; an empty one is at the place of its key."""
    if node is None or id(node) in seen:
        return node and seen[id(node)]
    seen[id(node)] = len(seen)
    place = key if key and node.start == node.end else (node.start, node.end)
    members = [
        (name, span, everything((node.members or {})[name], seen, span))
        for name, span in (node.keys or {}).items()
    ]
    items = [everything(item, seen) for item in node.items or []]
    return place, repr(node.value), node.plain, node.size, node.keys is None, members, items


def told(faults: list[YamlFault]) -> list[object]:
    return [(f.code, f.message, f.start, f.hint, f.length, f.first) for f in faults]


def seen_of(reading: Reading, text: str) -> object:
    """Everything observable about a reading."""
    root, faults, whole = reading
    found = traps(root, text) if root is not None and whole else []
    return everything(root, {}), told(faults), whole, told(found)


def compare(text: str) -> bool:
    """True if libyaml read the text; the result must then match ruamel.yaml's."""
    try:
        quick = read_by_libyaml(text)
    except Unlike:
        return False

    assert seen_of(quick, text) == seen_of(read_by_ruamel(text, Lines(text)), text)
    return True


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_files_are_read_alike_with_any_line_ends(path):
    text = path.read_text(encoding="utf-8").removeprefix("\ufeff")

    ends = ("\n", "\r\n", "\r")

    assert len({compare(text.replace("\n", end)) for end in ends}) == 1


def test_what_people_write_is_read_by_libyaml():
    left = [path.name for path in SHIPPED if not compare(path.read_text("utf-8"))]

    assert left == []


@pytest.mark.parametrize(
    "text",
    [
        "", "\n# c", "a", "'a'", "- - a\n  - b\n-\n  - c\n", "a:\n- b\n- c: d\n  e: f\ng: 1\n",
        "a: b\n  c\n\n  d\n", "a: |\n  b\n   c\n\n  d\n\n# e\nf: 1\n", "a: >-\n  b\n  c\n\n  d\nf: 1\n",
        "a: |2\n   b\n  c\n", "a: |1+\n  b\n\n\nc: 1", "a: >1-\n  b\n c\n", "a: |+ # c\n  b\n\n",
        "- |\n a\n- b", "a: |\n\n\n  b",
        "a: 'b\n  c'\n", 'a: "b\n\n  c"\n', r'a: "\n\x41\u00e9\U0001F600\"\/\0\N"',
        'a: "b\\\n   c"', "--- # c\n\na: 1", "---\na: 1\n...\n", "a: {b, c: 1, d: }\n", '{"a":1,"b":[]}\n',
        "a: {b: c\n  d, e: [1,\n # f\n 2,]}\n", "a: [1:30, x?y, a#b, -1, -x]\n", "a: {'b':c, 'd' :e, f?: g}",
        "null: 1\n010: 2\n'q': 3\n", "a b: c\n", "a:\nb: ''\n", "a: b:c\n", "a: b #c\n",
        "a: b#c\n", "? a\n: b\n? c\n",
        "? |\n a\n: b", "a: &x\n  b: 1\nc:\n  <<: *x\n",
        "a: &x {b: 1}\nc: {<<: [*x], d: *x}\n", "<<: 1", "a: 1\na: 2", "a: .nan", "a: no", "a: 0o10",
        "a: {{ b }}", "a: ${{ x # y }}\n", "a: “b”\n", "a: b\u00a0c", "a: b # c\td\n# \t\n",
        "😀: 😀\nb: [😀, '\U0010fffd']\n", "a: b\rc: d\r\re: |\r  f\r  g\r", f"{'a' * 1023}: 1\n",
    ],
)  # fmt: skip
def test_these_forms_are_read_by_libyaml_and_alike(text):
    assert compare(text)
    assert compare(text.replace("\n", "\r\n"))


@pytest.mark.parametrize(
    "text",
    [
        "a: !!str 1", "!x {}", "%YAML 1.2\n---\na: 1", "%TAG ! x\n---\na: 1", "a: 1\n---\nb: 2",
        "a: 1\n---", "a: *x",
        "a: &b.c 1\nd: *b.c", "a: &b: c", "*x?", "a: b\u2028c: d", "a: b\u2029", "a: b\x85",
        "a: \ufeffb", "a: \x07",
        "a: \ud800", 'a: "\\ud83d\\ude00"', "a:\tb", "a: b\t# c", "a: b\n\t\nc: d", "- 'a'\t",
        "['a':b]", "['a' :b]",
        "[{a: b}:c]", "[a: b]", "- [?] ]\n", "[a]: b", "a: |# b", "a: >-# b", "a: |\n   \n  b",
        ">\n#a", "--- |\n#a",
        "a: 'b", "a: @b", "a: b: c", "- a\nb: 1", "a: 1\n  b: 2", "{a: ${{ b }}}", "a\n: b",
        f"{'a' * 1025}: 1\n", "a: 1\n...\n...", "{?\n}", ": a", "a\u00a0#b\t# c",
    ],
)  # fmt: skip
def test_what_libyaml_refuses_or_may_read_otherwise_is_left(text):
    with pytest.raises(Unlike):
        read_by_libyaml(text)


def test_deep_nests_and_alias_bombs_end_both_readings_at_the_same_place():
    bomb = "a0: &a0 [x,x,x,x,x,x,x,x,x,x]\n" + "".join(
        f"a{n}: &a{n} [{f'*a{n - 1} ,' * 10}]\n" for n in range(1, 9)
    )

    assert compare("a: " + "[" * (DEEPEST - 1) + "]" * (DEEPEST - 1))
    for text in ("- " * (DEEPEST + 1) + "a", "[" * 900, "? " * 900, "{a: " * 900, bomb):
        quick = read_by_libyaml(text)
        assert seen_of(quick, text) == seen_of(read_by_ruamel(text, Lines(text)), text)
        assert told(quick[1])[0][0] == "E108"  # type: ignore[index]
    for text in ("[" * 2000, "{a: " * 2000):  # newer ones of libyaml give up at 1,000 levels
        _, problems = parse_source(text, Path("deep.yaml"), "deep.yaml")
        assert [problem.code for problem in problems] == ["E108"]


def test_without_libyaml_everything_is_read_by_ruamel(monkeypatch):
    text = (ROOT / "protocols/pegmatite_map.yaml").read_text("utf-8")
    with_it = parse_source(text, Path("a.yaml"), "a.yaml")[0]
    monkeypatch.setattr(yaml, "__with_libyaml__", False)
    without = parse_source(text, Path("a.yaml"), "a.yaml")[0]

    assert with_it is not None and without is not None
    assert everything(with_it.root, {}) == everything(without.root, {})


words = st.text(alphabet="ab1-:#,.{}[]'\"?é😀 &*!|>$~_+<=% \t", max_size=8)
values = st.one_of(
    words,
    words.map(lambda word: f'"{word}"'),
    words.map(lambda word: f"'{word}'"),
    st.sampled_from([
        "${{ a }}", "null", "010", "1e3", "a # c", "|\n    x\n     y\n\n    z\n", ">\n    x\n\n    z\n",
        "|-\n   x\n", "|+\n   x\n\n\n", ">2-\n     x\n\n", "|\n   \n  x", "a\n   b",
        "a\n\n      b c", "'a\n  b'",
        '"a\\n\\u00e9\\U0001F600"', '"a \\\n   b"', "{a: 1, b: [x, y]}", "[a, {b: c}]", "[\n a,\n # c\n b,]",
        "{a\n b: c}", "<<", "- a", "- a: 1", '{"a":1}', "{a: }", "{'a' :b}", "['a':b]", "[a: b]",
        "{? a}", "[?]",
        "&x a", "&x {a: b}", "*x", "!!str 1", "! a", "? a", "\u2028", "\ufeff", "a\u00a0b",
    ]),
)  # fmt: skip
before = st.sampled_from([
    "a: ", "b: ", "- ", "- a: ", "- - ", "", "c:", "'k': ", "a b: ", "#", "-", "k:", "? ", ": ",
    "<<: ", "&x a: ",
    "a: &x ", "- &x ", "*x : ",
])  # fmt: skip
line = st.builds(
    lambda indent, key, value, after: " " * indent + key + value + after,
    st.sampled_from([0, 0, 2, 2, 4, 4, 1, 3]), before, values,
    st.sampled_from(["", "", " # c", " ", "#x", "\t"]),
)  # fmt: skip


@pytest.mark.slow
@settings(max_examples=1000, deadline=None)
@given(
    st.sampled_from(["", "", "", "---\n", "--- ", "%YAML 1.2\n---\n", "# c\n\n"]),
    st.lists(line, max_size=7).map("\n".join),
    st.sampled_from(["", "\n", "\n\n", "\n  ", "\n# e", "\n...\n", "\n---"]),
    st.sampled_from(["\n", "\n", "\r\n", "\r"]),
)
def test_lines_of_all_kinds_are_read_alike(head, text, tail, end):
    compare((head + text + tail).replace("\n", end))


@settings(max_examples=1000, deadline=None)
@given(st.text(alphabet="ab:{}[],-'\"#$?|>&*! \n\n1", max_size=24))
def test_short_texts_of_all_kinds_are_read_alike(text):
    compare(text)
