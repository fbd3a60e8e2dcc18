"""Values in data: JSON that was answered, and what a library returned."""

import json
import math
from collections.abc import Mapping
from enum import Enum
from typing import Any

from .answers import (
    INFINITE,
    OWN,
    BadAnswer,
    NoNumber,
    items_of,
    may_lack,
    none_for,
    unmatched,
    value,
    values,
)


def plainly(data: Any) -> str:
    """As a form has it."""
    return data if isinstance(data, str) else json.dumps(data)


def found_at(data: Any, name: str, at: str, schema: dict[str, Any]) -> Any:
    """A value of JSON that was answered, at its place; raises BadAnswer or NoNumber."""
    single = not at and not isinstance(data, dict)
    parts = [] if single else (at or name).split(".")
    for number, part in enumerate(parts):
        if part == "*" and isinstance(data, list):
            rest, one = ".".join(parts[number + 1 :]), items_of(schema)
            return [found_at(each, name, rest, one) for each in data]
        try:
            data = data[int(part)] if isinstance(data, (list, tuple)) else data[part]
        except (KeyError, IndexError, ValueError, TypeError) as fault:
            if may_lack(schema):
                return None
            raise BadAnswer(f"the answer has no {at or name}: {str(data)[:80]}") from fault
    if set(OWN) & set(schema) and not isinstance(data, NoNumber):
        return value(plainly(data), schema)
    return plain(data, schema)


def json_values(text: str, returns: Mapping[str, Any]) -> dict[str, Any]:
    """Values of JSON, each where its `at` or its name says; a text that is none may be a single one.

    Raises BadAnswer or NoNumber.
    """
    try:
        told = json.loads(text)
    except ValueError as fault:
        if len(returns) > 1 or not text.strip() or any("at" in one for one in returns.values()):
            raise BadAnswer("it is no JSON") from fault
        told = text
    return {name: found_at(told, name, s.get("at", ""), s) for name, s in returns.items()}


def answer_values(
    text: str, returns: Mapping[str, Any], wanted: Any, *, json: bool, decimal: str = "."
) -> dict[str, Any]:
    """Values of an answer; of JSON, if it is that, or if that is in the group of a pattern.

    Raises BadAnswer or NoNumber.
    """
    if not json:
        return values(text, returns, wanted, decimal)
    if wanted is not None:
        found = wanted.fullmatch(text.strip())
        if found is None:
            raise unmatched(text.strip(), wanted)
        text = found[1 if wanted.groups else 0]
    return json_values(text, returns)


def plain(found: Any, schema: dict[str, Any]) -> Any:
    """A library's value as JSON has it; raises BadAnswer or NoNumber, which may stand for it, too."""
    if isinstance(found, NoNumber):
        return none_for(found.name, str(found), schema)
    if hasattr(found, "tolist"):  # numpy's, arrays and numbers
        found = found.tolist()
    if hasattr(found, "magnitude"):  # pint's
        from ...schemas.quantity import magnitude_in

        found = magnitude_in(found, schema.get("unit", ""))
    if isinstance(found, Enum):
        coded = isinstance(found, str) or (
            isinstance(found, int) and schema.get("type") != "string"
        )
        found = found.value if coded else found.name
    if isinstance(found, (list, tuple)):
        return [plain(one, schema.get("items", {})) for one in found]
    if isinstance(found, float) and math.isnan(found):
        return none_for("NotANumber", "it has no number", schema)
    if isinstance(found, float) and abs(found) >= INFINITE * (1 - 1e-6):
        return none_for("Overload", f"{found:g} is beyond its range", schema)
    kinds = schema.get("type", "number")
    if isinstance(found, str):  # a library hands on the text of what it cannot read as a number
        return value(found, schema)
    if kinds == "string" and isinstance(found, (bool, int, float)):
        return str(found)
    if found is None and "null" not in kinds:
        raise BadAnswer(f"it returned nothing, where {kinds} is expected")
    if isinstance(found, bool) and kinds in ("number", "integer"):
        raise BadAnswer(f"it returned {found!r}, where a {kinds} is expected")
    if found is not None and not isinstance(found, (bool, int, float, str)):
        raise BadAnswer(f"it returned {found!r}, where {kinds} is expected")
    return bool(found) if kinds == "boolean" and isinstance(found, (int, float)) else found
