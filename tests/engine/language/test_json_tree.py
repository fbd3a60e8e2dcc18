"""JSON is read by the rules of JSON, with the same places as YAML."""

import json
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from labrun.engine.language.json_tree import JsonReader
from labrun.engine.language.source import parse_source
from labrun.engine.language.yaml_node import YamlFault


def read(text: str, name: str = "p.json"):
    return parse_source(text, Path(name), name)


def test_places_are_counted_behind_tabs_too():
    source, problems = read('{\r\n\t"a":\t[1,\t{"b": "c"}]\r\n}')

    assert problems == []
    assert source is not None
    assert source.place(("a", 1, "b")) == (2, 17, 3)
    assert source.place(("a",), key=True) == (2, 2, 3)


def test_text_in_braces_is_json_without_its_suffix():
    source, problems = read('{"a":\t"\\/ \\ud83d\\ude00",\n\t"b": 1}', "p.yaml")

    assert problems == []
    assert source is not None and source.data == {"a": "/ \U0001f600", "b": 1}


def test_text_in_braces_that_is_no_json_is_yaml():
    source, problems = read("{a: 1, # one\n b: 'c'}", "p.yaml")

    assert problems == []
    assert source is not None and source.data == {"a": 1, "b": "c"}


@pytest.mark.parametrize("digits", ["123456789012345678901234567890", "-0", "0.1e-3", "1E2"])
def test_numbers_are_whole_as_far_as_they_go(digits):
    source, problems = read(f'{{"a": {digits}}}')

    assert problems == []
    assert source is not None
    assert repr(source.data["a"]) == repr(json.loads(digits))


@pytest.mark.parametrize("text", ["", " \n", "null"])
def test_an_empty_file_is_told(text):
    assert [problem.code for problem in read(text)[1]] == ["E100"]


@pytest.mark.parametrize("text", ["[" * 10_000, '{"a":' * 10_000, "[" * 5000 + "]" * 5000])
def test_a_deep_nest_is_a_problem_not_a_crash(text):
    for name in ("p.json", "p.yaml"):
        assert [problem.code for problem in read(text, name)[1]] == ["E108"]


values = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats(allow_nan=False, allow_infinity=False)
    | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=20,
)


@settings(max_examples=300, deadline=None)
@given(values, st.sampled_from([None, 1, "\t"]), st.booleans())
def test_whatever_json_writes_is_read_back(value, indent, ascii_only):
    node = JsonReader(json.dumps(value, indent=indent, ensure_ascii=ascii_only)).read()

    assert node is not None
    assert repr(node.value) == repr(value)


@settings(max_examples=500, deadline=None)
@given(st.text(alphabet='{}[],:"\\ntrue1.e-+0 \n\t/u#', max_size=30))
def test_what_python_reads_as_json_is_read_and_the_rest_is_refused(text):
    try:
        json.loads(text)
        fine = True
    except ValueError:
        fine = False
    reader = JsonReader(text)
    try:
        refused = reader.read() is None or bool(reader.faults)
    except YamlFault as fault:
        refused = True
        assert 0 <= fault.start <= len(text)

    assert refused != fine or "\\u" in text or "e" in text
