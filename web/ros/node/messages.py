"""rclpy messages to and from values: field name -> value, as in the rest of labrun."""

from typing import Any

from ..interfaces.kinds import Field, Message
from ..offers.offer import Values
from .types import nested_class

PLAIN = {"bool": bool, "float32": float, "float64": float, "int64": int, "string": str}


def from_message(kind: Message, message: Any) -> Values:
    """Every field of a message."""
    return {field.name: _read(field, getattr(message, field.name)) for field in kind.fields}


def fill(kind: Message, message: Any, values: Values) -> Any:
    """The message, its fields set."""
    for field in kind.fields:
        setattr(message, field.name, _made(field, values[field.name]))
    return message


def _read(field: Field, value: Any) -> Any:
    if field.array:
        return [_read_one(field, one) for one in value]
    return _read_one(field, value)


def _read_one(field: Field, value: Any) -> Any:
    if field.message is not None:
        return from_message(field.message, value)
    return PLAIN[field.type](value)  # array elements are numpy's


def _made(field: Field, value: Any) -> Any:
    if field.array:
        return [_made_one(field, one) for one in value]
    return _made_one(field, value)


def _made_one(field: Field, value: Any) -> Any:
    if field.message is not None:
        return fill(field.message, nested_class(field.message)(), value)
    return value
