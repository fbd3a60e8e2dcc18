"""What is made of a library's metadata; drivers/bridges/test_pymeasure.py writes whole entries."""

from importlib.util import find_spec

import pytest

from labrun.engine.new.device.from_pymeasure import _schema
from labrun.engine.new.device.sources import described
from labrun.engine.new.protocol import CannotMake


def test_another_library_is_refused_with_a_sentence():
    with pytest.raises(CannotMake, match=r"made from pymeasure:keithley\.Keithley2000"):
        described("dmm")


@pytest.mark.skipif(find_spec("pymeasure") is not None, reason="PyMeasure is installed here")
def test_without_the_library_it_says_what_brings_it():
    with pytest.raises(CannotMake, match=r'pip install "labrun\[pymeasure\]"'):
        described("pymeasure:a.B")


def truncated_range():
    """Stands for the library's validator: only its name is looked at."""


@pytest.mark.parametrize(
    ("values", "words", "schema"),
    [
        ([0, 1010], "a range in Volts, from 0",
         {"type": "number", "unit": "V", "minimum": 0, "maximum": 1010}),
        ([0, float("inf")], "a time (s)", {"type": "number", "unit": "s", "minimum": 0}),
        ({"on": 1, "off": 0}, "the beeper", {"type": "string", "enum": ["on", "off"]}),
        ({True: 1, False: 0}, "the output", {"type": "boolean"}),
        ((), "Get the name (string)", {"type": "string"}),
        ((), "the number of readings", {"type": "number"}),
    ],
)  # fmt: skip
def test_metadata_becomes_a_schema(values, words, schema):
    assert _schema({"values": values, "validator": truncated_range}, words) == schema
