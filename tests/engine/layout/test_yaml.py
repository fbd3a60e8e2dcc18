"""Formatting moves lines and nothing else; the meaning of a file stays the same."""

import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.layout.yaml import format_text, same

UNEVEN = """\
# head
labrun: 1 \x20
name:   even           # a name


steps:
# first
-   do: gantry.home      # go
    timeout: 2 min
    # within
-   id: inner
    steps:
    - do: gantry.move_to
      with: {
         x: 1 mm,   # a
         y: "2 mm"
      }
    -   log: |
            as it is
              stands  \t

            here
    - log: some
         plain text
    -   -   a
        - b
# after
finally:
        - log: "a
             b"
outputs: {}

# last


"""
EVEN = """\
# head
labrun: 1
name:   even           # a name


steps:
  # first
  - do: gantry.home      # go
    timeout: 2 min
    # within
  - id: inner
    steps:
      - do: gantry.move_to
        with: {
           x: 1 mm,   # a
           y: "2 mm"
        }
      - log: |
            as it is
              stands  \t

            here
      - log: some
           plain text
      - - a
        - b
# after
finally:
  - log: "a
       b"
outputs: {}

# last
"""


def even(text: str, name: str = "p.yaml") -> str:
    made, problems = format_text(text, name)

    assert problems == []
    return made


def test_lines_move_and_keep_their_words():
    assert even(UNEVEN) == EVEN
    assert even(EVEN) == EVEN


def test_line_ends_and_the_byte_order_mark_stay_as_most_are():
    windows = "\ufeff" + UNEVEN.replace("\n", "\r\n")

    assert even(windows) == "\ufeff" + EVEN.replace("\n", "\r\n")
    assert even("a: 1\r\nb: 2\nc: 3\n") == "a: 1\nb: 2\nc: 3\n"


@pytest.mark.parametrize(
    "text",
    [
        "a: &x {b: 1}\nc: *x\n", "a: &x\n    b: 1\nc:\n    <<: *x\n", "---\na:\n    b: 1\n",
        "a: |+\n    b\n\n\n",
        "a: |2\n   b\n", "a: >-\n   b\n   c\n\n     d\n", "a:\n- &x b: 1\n- *x\n",
        "? a\n:   b\n", "[\na,\n  b]\n",
        "a:\n    'b':   # c\n        - d\n", "a:\n   # b\n   c: 1\n # d\n", "- - - a\n- b\n", "a",
        "'a\n\n  b'",
        "a:\n  - b\n #c\n", "a:\r  b: 1\r", 'a: "b\\\n     c"\n', "a: # b\n    c\n", "a:\n  -\n      b: 1\n",
    ],
)  # fmt: skip
def test_rarer_forms_keep_their_meaning_and_settle_at_once(text):
    assert even(even(text)) == even(text)


def test_json_is_laid_out_with_its_numbers_and_escapes_as_written():
    text = '{"a":1.50,"b":[ ],\n"c":{"d":"\\u00e9\\/", "e":[' + ",".join(["1e3"] * 30) + "]}}"
    made = even(text, "p.json")

    assert made.startswith('{\n  "a": 1.50,\n  "b": [],\n  "c": {\n    "d": "\\u00e9\\/",\n')
    assert made.count("1e3") == 30
    assert even(made, "p.json") == made


def test_what_is_not_yaml_is_refused_with_the_problems_of_check():
    text = "a:\n\tb: 1\n"
    made, problems = format_text(text, "p.yaml")

    assert made == text
    assert [(p.code, p.line, p.column) for p in problems] == [("E101", 2, 1)]


def test_the_same_means_the_same_type_and_order():
    assert not same({"a": 1}, {"a": 1.0})
    assert not same({"a": 1}, {"a": True})
    assert not same({"a": 1, "b": 2}, {"b": 2, "a": 1})
    assert same({"a": [1, None]}, {"a": [1, None]})


values = st.sampled_from([
    "1", "text", "a # c", "|\n        x\n         y\n\n        z\n", "'a\n    b'", '"a"',
    "{a: 1, b: [x,\n y]}",
    "[a,\n# c\n b]", "a\n       b", "", "# c",
])  # fmt: skip
nodes = st.recursive(
    values.map(lambda value: [" " + value]),
    lambda inner: st.one_of(
        st.tuples(st.lists(inner, min_size=1, max_size=3), st.sampled_from(["-", "-   "])).map(
            lambda made: ["", *(f"{made[1]}{line}" if not n else f"      {line}"
                                for item in made[0] for n, line in enumerate(item))]
        ),
        st.tuples(st.lists(inner, min_size=1, max_size=3), st.sampled_from([1, 2, 4, 5])).map(
            lambda made: ["", *(f"k{key}:{line}" if not n else f"{' ' * made[1]}{line}"
                                for key, item in enumerate(made[0]) for n, line in enumerate(item))]
        ),
        inner.map(lambda lines: [lines[0], "  # note", *lines[1:]]),
        inner.map(lambda lines: [lines[0], "", *lines[1:]]),
    ),
    max_leaves=8,
)  # fmt: skip


@settings(max_examples=400, deadline=None)
@given(nodes, st.booleans())
def test_even_form_settles_at_once_and_keeps_every_word(lines, windows):
    text = "\n".join(lines) + "\n"
    made, problems = format_text(text.replace("\n", "\r\n") if windows else text, "p.yaml")
    if problems:
        return

    assert format_text(made, "p.yaml") == (made, [])
    assert re.findall(r"\S+", made) == re.findall(r"\S+", text)
    assert ("\r\n" in made) == windows
