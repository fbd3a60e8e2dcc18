"""Usual units need no pint: what is done without it is what pint would have done."""

import itertools

import pytest

from labrun.schemas.quantity import (
    KINDS,
    PLAIN,
    SIZES,
    UnitError,
    kind_of_unit,
    magnitude_in,
    parse_quantity,
    plainly,
    quantity_text,
    registry,
    seconds,
    unit_of,
)

PAIRS = [
    pytest.param(own, wanted, id=f"{own}-{wanted}")
    for sizes in SIZES.values()
    for own, wanted in itertools.product(sizes, repeat=2)
]
NUMBERS = ("0", "1", "-3", "0.2", "12.75", "1e3", "+.5", "123456.789", "0.1000000000001")


@pytest.mark.parametrize(("own", "wanted"), PAIRS)
def test_a_plain_unit_is_converted_as_pint_converts_it(own, wanted):
    for number in NUMBERS:
        by_pint = magnitude_in(parse_quantity(f"{number} {own}"), wanted)
        plain = plainly(f" {number} {own} ", wanted)

        assert plain == by_pint
        assert type(plain) is type(by_pint)


@pytest.mark.parametrize("unit", PLAIN)
def test_a_plain_unit_measures_what_pint_says(unit):
    dimension = next(key for key, words in KINDS.items() if words == kind_of_unit(unit))

    assert unit_of(unit).dimensionality == registry().get_dimensionality(dimension)


@pytest.mark.parametrize("text", ["5", "5 kg", "5 degC", "5 mm/s", "5 mµ", "five mm", "5 mm mm"])
def test_what_is_not_plain_is_left_to_pint(text):
    assert plainly(text, "mm") is None


def test_an_angstrom_is_one_in_either_of_its_characters():
    assert {magnitude_in(f"500 {sign}", "nm") for sign in "\u00c5\u212b"} == {50.0}


def test_a_duration_in_any_unit_of_time_is_in_seconds():
    assert [seconds(text) for text in ("250 ms", "2 min", "1.5 h", "1 day", 3)] == [
        0.25, 120.0, 5400.0, 86400.0, 3.0,
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("text", "wanted", "says"),
    [
        ("1 mn", "s", "'mn' is not a unit; did you mean min?"),
        ("1 mn", "mm", "'mn' is not a unit"),
        ("1 gr", "g", "'gr' would be a grain, 0.065 g; did you mean g?"),
        ("1 MM", "mm", "'MM' would be a megamolar; did you mean mm?"),
        ("1 PA", "Pa", "'PA' would be a petaampere; did you mean Pa?"),
        ("1 Sec", None, "'Sec' is not a unit; did you mean s?"),
        ("2 ㎜", "mm", "'㎜' is not a unit; did you mean mm?"),
        ("2 мкм", "mm", "'мкм' is not a unit; did you mean µm?"),
        ("20 ℃", "K", "'℃' is not a unit; did you mean degC?"),
        ("20 ˚C", "degC", "'˚C' is not a unit; did you mean degC?"),
        ("20 mg∕L", "mg/L", "'mg∕L' is not a unit; did you mean mg/L?"),
        ("2 mm☃", "mm", "'mm☃' is not a unit: it holds ☃ (U+2603)"),
        ("3 × 4", "mm", "'3 × 4' is not a number with a unit, such as `0.2 mm`"),
        ("0,5 mm", "mm", "'0,5 mm' is not a number with a unit, such as `0.5 mm`"),
    ],
)
def test_a_unit_that_is_proposed_is_of_the_kind_that_is_wanted(text, wanted, says):
    with pytest.raises(UnitError) as fault:
        parse_quantity(text, wanted)

    assert str(fault.value) == says


def test_no_unit_is_told_as_defined_again(caplog):
    made = registry.__wrapped__()

    assert made.Quantity(1, "slm").check("[length]**3 / [time]")
    assert caplog.records == []


@pytest.mark.parametrize("text", ["2 mL", "5 µL", "3 L", "0.1 mol/L", "20 mL/min"])
def test_a_litre_is_written_with_the_letter_that_nobody_takes_for_a_one(text):
    assert quantity_text(parse_quantity(text.replace("L", "l"))) == text
