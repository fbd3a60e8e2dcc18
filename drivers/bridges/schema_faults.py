"""What is wrong in the schema of a parameter or a result, as a lab's config says it."""

from collections.abc import Collection, Iterator
from difflib import get_close_matches
from typing import Any

from ...schemas.patterns import (
    PatternFault,
    check_schema,
    ranges_of_nothing,
    regular_expression,
    schema_fault_words,
    unknown_keywords,
)
from ...schemas.quantity import unit_fault
from .answers import OWN, words_of
from .number_forms import form_faults

Path = tuple[str | int, ...]


def schema_faults(
    name: str, schema: dict[str, Any], own_keys: Collection[str], elsewhere: str
) -> Iterator[tuple[Path, str, bool]]:
    """(path, message, whether it is about the key): `own_keys` say how a value is written here."""
    from jsonschema import SchemaError

    try:
        check_schema(schema)
    except SchemaError as fault:
        yield tuple(fault.absolute_path), schema_fault_words(fault), False
        return
    for place, said in ranges_of_nothing(schema):
        yield place, said, False
    if "unit" in schema and (
        said := unit_fault(str(schema["unit"]), f"{name} {schema.get('description', '')}")
    ):
        yield ("unit",), said, False
    for path, known in unknown_keywords(schema, own_keys):
        key = str(path[-1])
        near = get_close_matches(key, known, n=1)
        hint = elsewhere if key in OWN else f"; did you mean {near[0]}?" if near else ""
        yield path, f"unknown key {key!r}{hint}", True
    for key, message in own_faults({k: v for k, v in schema.items() if k in own_keys}, schema):
        yield (key,), message, False


def bits_fault(which: Any) -> str:
    """What is wrong in the first and the last of some bits; empty if nothing is."""
    good = isinstance(which, (list, tuple)) and len(which) == 2
    if good and all(isinstance(one, int) for one in which) and 0 <= which[0] <= which[1]:
        return ""
    return "it is the first and the last bit, from 0 for the lowest: [4, 7]"


def own_faults(own: dict[str, Any], schema: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """(key, message) of what says how a value is written, and cannot be."""
    if own.get("scale", 1) == 0 or not isinstance(own.get("scale", 1), (int, float)):
        yield "scale", "it is a number other than 0: value = what is written × scale + offset"
    if not isinstance(own.get("offset", 0), (int, float)):
        yield "offset", "it is a number: value = what is written × scale + offset"
    if own.get("base", 10) not in (2, 8, 10, 16):
        yield "base", "it is 2, 8, 10 or 16"
    if not isinstance(own.get("bit", 0), int) or own.get("bit", 0) < 0:
        yield "bit", "it is the number of a bit, from 0 for the lowest"
    if fault := bits_fault(own.get("bits", [0, 0])):
        yield "bits", fault
    nothing = own.get("nothing", [])
    if not isinstance(nothing, list) or not all(
        isinstance(one, (int, float, str)) and not isinstance(one, bool) for one in nothing
    ):
        yield (
            "nothing",
            'it is a list of what stands for no value, as it is written: [-999, "none"]',
        )
    if own.get("decimal", ",") not in (".", ","):
        yield "decimal", "it is a point or a comma"
    try:
        regular_expression(str(own.get("header", "")))
    except PatternFault as fault:
        yield "header", f"it is not a regular expression: {fault}"
    yield from form_faults(own)
    if "words" in own and not (isinstance(own["words"], dict) and own["words"]):
        yield "words", 'say what the instrument writes for each value: {idle: "0", running: "1"}'
    elif "words" in own:
        try:
            words_of(schema)
        except ValueError as fault:
            yield "words", f"the values of a number are numbers: {fault}"
