"""What is written as YAML reads back as itself, whatever an instrument wants to be sent."""

import io
import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruamel.yaml import YAML

from labrun.engine.language.yaml_lines import Lines
from labrun.engine.language.yaml_read import read_nodes
from labrun.engine.language.yaml_write import write_yaml

SIGNS = list(":?-#{}[],&*!|>'\"%@` ab1=~<.\n\t\r\x03é")


def check(text):
    for data in (
        {"a": {"b": text, "c": [text, {"d": text}]}},
        {"a": text, "b": {"c": {}}},
        {"a": {text: 1}},
        {"b": {"write": {"target": text, "command": 1}}, "a": text},
    ):
        out = io.StringIO()
        write_yaml(data, out)
        _, faults, whole = read_nodes(out.getvalue(), Lines(out.getvalue()), json=False)

        read = YAML(typ="safe", pure=True).load(out.getvalue())
        assert (read, json.dumps(read)) == (data, json.dumps(data))
        assert (faults, whole) == ([], True)


@pytest.mark.parametrize(
    "text", [":MEAS:VOLT:DC?", "?ID", "? x", ":", "*IDN?", "\x03", "a: b", "no"]
)
def test_a_command_is_read_back(text):
    check(text)


@settings(max_examples=100)
@given(st.text(st.sampled_from(SIGNS), max_size=8))
def test_any_text_is_read_back(text):
    check(text)
