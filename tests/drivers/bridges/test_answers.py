"""Numbers as instruments write them."""

import re

import pytest

from labrun.drivers.bridges.answers import BadAnswer, NoNumber, value, values
from labrun.schemas.quantity import registry

VOLT, CELSIUS = {"type": "number", "unit": "V"}, {"type": "number", "unit": "degC"}


@pytest.mark.parametrize(
    ("text", "schema", "wanted"),
    [
        ("1.23", VOLT, 1.23),
        ("+1.2300E+00", VOLT, 1.23),
        ("1.23 V", VOLT, 1.23),
        ("+1.23E+00VDC", VOLT, 1.23),
        ("1230mV", VOLT, 1.23),
        ("0.00123 KV", VOLT, 1.23),
        (" - 5 ", VOLT, -5.0),
        (".5", VOLT, 0.5),
        ("25.5 C", CELSIUS, 25.5),
        ("77 F", CELSIUS, 25.0),
        ("25.5 °C", CELSIUS, 25.5),
        ("298.65 K", CELSIUS, 25.5),
        ("+3.000E+00", {"type": "integer"}, 3),
        ("ON", {"type": "boolean"}, True),
        ("0", {"type": "boolean"}, False),
        ('"DM 1"', {"type": "string"}, "DM 1"),
        ('"3"" pan"', {"type": "string"}, '3" pan'),
        ("1, 2;3 4", {"type": "array", "items": {"type": "integer"}}, [1, 2, 3, 4]),
        ("+1.25D-03 V", {"type": "number", "unit": "mV"}, 1.25),
        ("45 %RH", {"type": "number", "unit": "%"}, 45.0),
        ("1.5E-3 MBAR", {"type": "number", "unit": "mbar"}, 0.0015),
        ("5 MIN", {"type": "number", "unit": "s"}, 300.0),
        ("5 MOHM", {"type": "number", "unit": "ohm"}, 5e6),
        ("1.2 LPM", {"type": "number", "unit": "ml/min"}, 1200.0),
        ("0.4 ppb", {"type": "number", "unit": "ppm"}, 0.0004),
        ("10 mW", {"type": "number", "unit": "dBm"}, 10.0),
        ("5 mOhm", {"type": "number", "unit": "ohm"}, 0.005),
        ("5 VOLTS", VOLT, 5.0),
        ("12.5 sccm", {"type": "number", "unit": "sccm"}, 12.5),
        ("0.5 SLM", {"type": "number", "unit": "sccm"}, 500.0),
        ("#H2A", {"type": "integer"}, 42),
        ("50 %", {"type": "number", "unit": "percent"}, 50.0),
        ("9.9E37", {"type": ["number", "null"]}, None),
        ("-999.0 C", {"type": ["number", "null"], "unit": "degC", "nothing": [-999]}, None),
        ("none", {"type": ["number", "null"], "unit": "degC", "nothing": ["None"]}, None),
        ('"N/A"', {"type": ["string", "null"], "nothing": ["n/a"]}, None),
        (
            "1,,3",
            {"type": "array", "items": {"type": ["number", "null"]}, "nothing": [""]},
            [1, None, 3],
        ),
        ("8001", {"type": ["number", "null"], "base": 16, "scale": 0.1, "nothing": [32769]}, None),
        ("100 PF", {"type": "number", "unit": "nF"}, 0.1),  # no petafarad
        ("10 mhz", {"type": "number", "unit": "MHz"}, 10.0),
        ("2 ghz", {"type": "number", "unit": "MHz"}, 2000.0),
        ("500 cm-1", {"type": "number", "unit": "1/cm"}, 500.0),
        ("3 m3/h", {"type": "number", "unit": "L/min"}, 50.0),
        ("12345678901234567", {"type": "integer"}, 12345678901234567),
        ("1.2 V, 900 mV", {"type": "array", "items": VOLT}, [1.2, 0.9]),
        (
            "run 1.csv,run 2.csv",
            {"type": "array", "items": {"type": "string"}},
            ["run 1.csv", "run 2.csv"],
        ),
        ("1,2,", {"type": "array"}, [1.0, 2.0]),
        ("2A", {"type": "integer", "base": 16, "bits": [1, 3]}, 5),
        ("2A", {"base": 16, "bits": [4, 5], "words": {"idle": 1, "busy": 2}}, "busy"),
        ("\0\0\x41\xac", {**VOLT, "bytes": "><f4"}, 21.5),
        ("AC410000", {**VOLT, "bytes": "<>f4", "base": 16}, 21.5),
        ("00010000FFFFFFFF", {"type": "array", "bytes": "><i4", "base": 16}, [1, -1]),
        ("23,5 V", {**VOLT, "decimal": ","}, 23.5),
        ("-05000-01", {**VOLT, "mantissa": 5, "scale": 1e4}, -500.0),
    ],
)
def test_a_value_is_read_in_the_contracts_unit(text, schema, wanted):
    registry()
    assert (
        value(text, schema) == pytest.approx(wanted)
        if isinstance(wanted, float)
        else (value(text, schema) == wanted)
    )


@pytest.mark.parametrize(
    ("text", "schema", "words"),
    [
        ("1.23 s", VOLT, "its unit is 's', wanted is"),
        ("1.23 bananas", VOLT, "its unit is 'bananas'"),
        (
            "hello",
            VOLT,
            r"'hello' is not a number; if it stands for none, say `nothing: \['hello'\]`",
        ),
        ("1.5", {"type": "integer"}, "not a whole number"),
        ("23,5 V", VOLT, "a decimal comma"),
        ("086,040", VOLT, r"two values\? Then each is a group"),
        ("maybe", {"type": "boolean"}, "neither on nor off"),
        ("1.5 V", {"type": "number"}, "the contract has none"),
        (
            "0 mW",
            {"type": "number", "unit": "dBm"},
            "0 mW has no logarithm, so it is nothing in dBm",
        ),
        ("1230 MV", VOLT, "MV may be megavolt or millivolt"),
        (
            "10 mhz",
            {"unit": "Hz"},
            "mhz may be megahertz or millihertz; an `answer: '(.*) mhz'` picks",
        ),
        ("60 rpm", {"unit": "Hz"}, "whether a turn or a radian is meant"),
        ("253", {"type": "integer", "scale": 0.1}, "25.3 is not a whole number"),
        ("1,,3", {"type": "array"}, "'' is not a number"),
        (
            "12.34 g ?",
            {"type": "number", "unit": "g"},
            r"'g \?', which stands behind the number, is no unit",
        ),
    ],
)
def test_what_is_no_such_value_is_said(text, schema, words):
    with pytest.raises(BadAnswer, match=words):
        value(text, schema)


@pytest.mark.parametrize(
    ("text", "name"),
    [("9.9E37", "Overload"), ("-9.90000000E+37", "Overload"), ("OVLD", "Overload"),
     ("+OL", "Overload"), ("OVL", "Overload"), ("O.L", "Overload"), ("UNDER", "Overload"),
     ("inf", "Overload"), ("OVER", "Overload"), ("----", "NotANumber"),
     ("--.- V", "NotANumber"), (".......", "NotANumber"),
     ("9.91E37", "NotANumber"), ("NaN", "NotANumber"), ("1E300", "Overload")],
)  # fmt: skip
def test_no_number_has_its_name(text, name):
    with pytest.raises(NoNumber) as fault:
        value(text, VOLT)

    assert fault.value.name == name


def test_a_decimal_comma_is_read_where_it_is_said():
    returns = {"x": VOLT, "t": CELSIUS}

    assert values("2,5 V; 23,5", returns, None, ",") == {"x": 2.5, "t": 23.5}
    assert values("T=23,5 X=2", returns, re.compile("T=(?P<t>.*) X=(?P<x>.*)"), ",") == {
        "x": 2.0,
        "t": 23.5,
    }


def test_a_pattern_gives_names_or_an_order():
    returns = {"x": VOLT, "on": {"type": "boolean"}}

    assert values("on=1 x=2 V", returns, re.compile("on=(?P<on>.) x=(?P<x>.*)")) == {
        "x": 2.0,
        "on": True,
    }
    assert values("<2|off>", returns, re.compile(r"<(.*)\|(.*)>")) == {"x": 2.0, "on": False}
    with pytest.raises(BadAnswer, match="it has 1 of 2 values"):
        values("2", returns, re.compile("(.)"))
    with pytest.raises(BadAnswer, match="it has no on"):
        values("2", returns, None)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("1,2,3", "it has 3 values, and 2 are wanted; an `answer` picks them"),
        ("1,5;2,5", "it has 4 values, and 2 are wanted; a decimal comma"),
        ("1;2;3\n4;5;6", r"of the row \['1', '2', '3'\]: it has 3 values"),
        ("1;;3\n4;5;6", r"of the row \['1', '', '3'\]: it has 3 values"),
    ],
)
def test_values_that_nobody_wanted_are_no_others(text, words):
    one = {"type": "array"} if "\n" in text else {"type": "number"}

    with pytest.raises(BadAnswer, match=words):
        values(text, {"a": one, "b": one}, None)

    assert values("1,2,", {"a": {"type": "number"}, "b": {"type": "number"}}, None) == {
        "a": 1,
        "b": 2,
    }


@pytest.mark.parametrize(("pattern", "part"), [("T=(.*)C", True), ("P=(.*)", False)])
def test_an_answer_of_which_only_a_part_fits_its_pattern_is_told_so(pattern, part):
    with pytest.raises(BadAnswer, match="does not match") as told:
        values("T=21.5C OK", {"t": {}}, re.compile(pattern))

    assert ("only a part of it does" in str(told.value)) is part
