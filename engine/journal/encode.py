"""Values of a run as JSON and back: quantities keep their unit."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

from ...schemas.quantity import is_quantity, quantity

QUANTITY_KEY = "$quantity"
MOMENT_KEY = "$moment"
PLAIN = frozenset((str, int, float, bool, type(None)))
"""Types whose values are JSON data already, as nearly all are."""


def encode(value: Any) -> Any:
    """A value as plain JSON data."""
    if type(value) in PLAIN:
        return value
    if isinstance(value, Mapping):
        return {
            str(key): item if type(item) in PLAIN else encode(item) for key, item in value.items()
        }
    if is_quantity(value):
        return {QUANTITY_KEY: [value.magnitude, f"{value.units:~}"]}
    if isinstance(value, datetime):
        return {MOMENT_KEY: value.isoformat()}
    if isinstance(value, Sequence) and not isinstance(value, str | bytes):
        return [encode(item) for item in value]
    if value is None or isinstance(value, str | int | float | bool):
        return value
    return str(value)


def decode(value: Any) -> Any:
    """A value from its plain JSON data."""
    if isinstance(value, dict):
        if QUANTITY_KEY in value:
            magnitude, unit = value[QUANTITY_KEY]
            return quantity(magnitude, unit)
        if MOMENT_KEY in value:
            return datetime.fromisoformat(value[MOMENT_KEY])
        return {key: decode(item) for key, item in value.items()}
    if isinstance(value, list):
        return [decode(item) for item in value]
    return value


def with_units(value: Any, schema: Mapping[str, Any]) -> Any:
    """A device's result with the units of its contract's `returns` put to its bare numbers."""
    if value is None:
        return None
    unit = schema.get("unit")
    if unit and isinstance(value, int | float) and not isinstance(value, bool):
        return quantity(value, unit)
    if isinstance(value, dict):
        properties = schema.get("properties", {})
        rest = schema.get("additionalProperties")
        other = rest if isinstance(rest, dict) else {}
        return {key: with_units(item, properties.get(key, other)) for key, item in value.items()}
    if isinstance(value, list) and isinstance(schema.get("items"), dict):
        return [with_units(item, schema["items"]) for item in value]
    return value
