"""Convert values between ROS and a contract: every field is typed, and none is missing."""

import json
import math
from typing import Any

from ....engine.language.suggest import did_you_mean
from .kinds import Field, Message

INT64 = 2**63
FLOATS = ("float32", "float64")
BLANK: dict[str, Any] = {
    "bool": False, "int64": 0, "float32": math.nan, "float64": math.nan, "string": "",
}  # fmt: skip


class ValueFault(ValueError):
    """A value that a message does not accept, with its position."""


def from_ros(message: Message, values: Any, place: str = "") -> dict[str, Any]:
    """The contract data for a client's values; raises ValueFault.

    Fields that a client leaves out stay out: defaults come from the contract.
    """
    if not isinstance(values, dict):
        raise ValueFault(f"{place or message.name} is {_kind(values)} but must be an object")
    fields = {field.name: field for field in message.fields}
    data: dict[str, Any] = {}
    for name, value in values.items():
        if name not in fields:
            knows = ", ".join(fields) or "none"
            hint = did_you_mean(str(name), fields)
            raise ValueFault(
                f"{_at(place, name)} is not a field of {message.name}{hint}; its fields are {knows}"
            )
        taken = _take(fields[name], value, _at(place, name))
        if taken is not None:
            data[fields[name].key] = taken
    return data


def _take(field: Field, value: Any, place: str) -> Any:
    if field.json:
        return _from_text(value, place)
    if not field.array:
        return _one(field, value, place)
    if field.optional:
        if value is None or value == []:
            return None
        # A client without the type definition writes the bare value.
        values = value if isinstance(value, list) else [value]
        if len(values) > 1:
            raise ValueFault(f"{place} has {len(values)} values but takes at most one")
        return _one(field, values[0], place)
    if not isinstance(value, list):
        raise ValueFault(f"{place} is {_kind(value)} but must be a list")
    return [_one(field, item, f"{place}[{index}]") for index, item in enumerate(value)] or None


def _one(field: Field, value: Any, place: str) -> Any:
    if field.message is not None:
        return from_ros(field.message, value, place)
    good = {
        "bool": isinstance(value, bool),
        "string": isinstance(value, str),
        "int64": isinstance(value, int) and not isinstance(value, bool),
    }.get(field.type, isinstance(value, (int, float)) and not isinstance(value, bool))
    if not good:
        raise ValueFault(f"{place} is {_kind(value)} but must be a {field.type}")
    if field.type == "int64" and not -INT64 <= value < INT64:
        raise ValueFault(f"{place} is {value}, which is not an int64")
    if field.type in FLOATS and not math.isfinite(value):
        raise ValueFault(f"{place} is {value}, which is not a finite number")
    return value


def _from_text(value: Any, place: str) -> Any:
    if not isinstance(value, str):
        raise ValueFault(f"{place} is {_kind(value)} but must be a string of JSON")
    if not value:
        return None
    try:
        return json.loads(value)
    except (ValueError, RecursionError) as fault:
        raise ValueFault(f"{place} is not JSON: {fault}") from fault


def to_ros(message: Message, data: dict[str, Any] | None) -> dict[str, Any]:
    """Every field of a message, filled from contract data; absent values are blank."""
    given = data or {}
    return {field.name: _give(field, given.get(field.key)) for field in message.fields}


def _give(field: Field, value: Any) -> Any:
    if field.json:
        return "" if value is None else json.dumps(value, ensure_ascii=False)
    if not field.array:
        return _given_one(field, value)
    values = [] if value is None else value if isinstance(value, list) else [value]
    return [_given_one(field, item) for item in values]


def _given_one(field: Field, value: Any) -> Any:
    if field.message is not None:
        return to_ros(field.message, value if isinstance(value, dict) else None)
    if value is None:
        return BLANK[field.type]
    if field.type in FLOATS:
        return float(value)
    if field.type == "string" and field.bound is not None:
        return str(value)[: field.bound]
    return value


def _at(place: str, name: object) -> str:
    return f"{place}.{name}" if place else str(name)


def _kind(value: Any) -> str:
    kinds = {bool: "a boolean", str: "a string", list: "a list", dict: "an object"}
    return "null" if value is None else kinds.get(type(value), "a number")
