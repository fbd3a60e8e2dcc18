"""Fit one argument to its contract: convert units, check it against the JSON Schema."""

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from ...schemas.patterns import validator as json_validator
from ...schemas.quantity import (
    QUANTITY,
    UnitError,
    converts,
    is_quantity,
    kind_of_unit,
    magnitude_in,
    parse_quantity,
    plainly,
    quantity_text,
    unit_meant,
)  # fmt: skip
from .moments import moment_text
from .operators import words
from .suggest import did_you_mean, listed
from .wanted import TYPE_WORDS, ArgumentFault, Wanted, check_limit, outside, quotes_for_text, wants
from .yaml_characters import odd_characters
from .yaml_traps import point_for


def fit(value: Any, wanted: Wanted) -> Any:
    """The value as its driver gets it; raises ArgumentFault."""
    value = _unpack(value, wanted)
    if isinstance(value, float) and not math.isfinite(value):
        # Neither a minimum nor a maximum refuses NaN.
        raise wanted.fault(
            f"{value} is not a finite number, the device wants {wants(wanted.schema)}"
        )
    fault = next(iter(validator(wanted.schema).iter_errors(value)), None)
    if fault is not None:
        raise _in_words(fault, value, wanted)
    check_limit(value, wanted)
    return value


def _unpack(value: Any, wanted: Wanted) -> Any:
    """The value with every quantity in it as a bare number in the contract's unit."""
    schema, unit = wanted.schema, wanted.unit
    if isinstance(value, datetime):
        return moment_text(value)
    if isinstance(value, Mapping):
        properties = schema.get("properties", {})
        return {
            key: _unpack(
                item, Wanted(properties.get(key, {}), None, f"{wanted.param}.{key}", wanted.label)
            )
            for key, item in value.items()
        }
    if isinstance(value, Sequence) and not isinstance(value, str):
        inner = schema.get("items", {})
        inner = inner if isinstance(inner, Mapping) else {}
        if len(value) > 100_000:
            raise wanted.fault(f"a list of {len(value):,} items is too long for an argument")
        return [
            _unpack(item, Wanted(inner, None, f"{wanted.param}[{i}]", wanted.label))
            for i, item in enumerate(value)
        ]
    if unit is not None:
        return _in_unit(value, unit, wanted)
    if is_quantity(value):
        what = f"{quantity_text(value)} is {kind_of_unit(str(value.units))}"
        raise wanted.fault(f"{what}, the device wants {wants(schema)}", code="E204")
    return value


def _in_unit(value: Any, unit: str, wanted: Wanted) -> Any:
    device_wants = f"the device wants {wants(wanted.schema)}"
    if isinstance(value, str):
        if not QUANTITY.match(value):
            number = ""
            if _is_number(value):
                number = f"if {value.strip()} {unit} is meant, write it without quotes"
            else:
                number = (
                    point_for(value.strip())
                    or odd_characters(value)
                    or f"such as {wanted.param}: 1 {unit}"
                )
                if value.isidentifier():
                    number += f", or ${{{{ {value} }}}} for what the name {value} stands for"
            raise wanted.fault(f"{words(value)} is text, {device_wants}", number)
        if (plain := plainly(value, unit)) is not None:
            return plain
        try:
            value = parse_quantity(value, unit)
        except UnitError as fault:
            what, _, guess = str(fault).partition("; ")
            raise wanted.fault(f"{what}; {device_wants}", guess, code="E204") from fault
    if not is_quantity(value):
        return value
    if not converts(value.units, unit):
        what = f"{quantity_text(value)} is {kind_of_unit(str(value.units))}"
        guess = unit_meant(value, unit).removeprefix("; ")
        raise wanted.fault(f"{what}, {device_wants}", guess, code="E204")
    try:
        return magnitude_in(value, unit)
    except UnitError as fault:
        what, _, way = str(fault).partition("; ")
        raise wanted.fault(what, way, code="E204") from fault


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _in_words(fault: Any, value: Any, wanted: Wanted) -> ArgumentFault:
    kind, at = fault.validator, "".join(f"[{part}]" for part in fault.absolute_path)
    schema = fault.schema if isinstance(fault.schema, Mapping) else {}
    path = (wanted.param.partition(".")[0], *fault.absolute_path)
    there = Wanted(schema, wanted.limit if not at else None, f"{wanted.param}{at}", wanted.label)
    if kind in ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum"):
        return outside(fault.instance, there, "the contract")
    if kind == "type":
        is_what = TYPE_WORDS.get(_json_type(fault.instance), "a value")
        said = (
            f"{words(fault.instance)} is {is_what}"
            if fault.instance is not None
            else "there is no value (null)"
        )
        if isinstance(fault.instance, list | dict):
            said = f"this is {is_what}"
        return there.fault(
            f"{said}, the device wants {wants(schema)}",
            quotes_for_text(fault.instance, schema),
            path=path,
        )
    if kind == "enum":
        options = [str(item) for item in fault.validator_value]
        guess = did_you_mean(str(fault.instance), options)
        return there.fault(
            f"{words(fault.instance)} is not one of {listed(options)}{guess}",
            code="E207",
            path=path,
        )
    if kind == "pattern":
        return there.fault(
            f"{words(fault.instance)} does not fit the pattern {fault.validator_value}",
            code="E207",
            path=path,
        )
    if kind == "required":
        return there.fault(
            fault.message.replace("is a required property", "is missing"), code="E205", path=path
        )
    return there.fault(plain(fault), code="E207", path=path)


def plain(fault: Any) -> str:
    """The message of jsonschema, if it is short."""
    text = str(fault.message)
    return text if len(text) < 200 else f"does not fit the contract's {fault.validator}"


def _json_type(value: Any) -> str:
    kinds = {
        bool: "boolean",
        int: "integer",
        float: "number",
        str: "string",
        list: "array",
        dict: "object",
    }
    return kinds.get(type(value), "null")


_VALIDATORS: dict[int, tuple[Any, Any]] = {}


def validator(schema: Mapping[str, Any]) -> Any:
    """The cached validator of a schema; the schema is kept alive so that its id is not reused."""
    found = _VALIDATORS.get(id(schema))
    if found is None or found[0] is not schema:
        if len(_VALIDATORS) > 10_000:
            _VALIDATORS.clear()
        found = _VALIDATORS[id(schema)] = (schema, json_validator(schema))
    return found[1]
