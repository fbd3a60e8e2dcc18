"""Convert rclpy messages to and from plain values, without a definition at hand."""

import re
from importlib import import_module
from typing import Any


def as_values(message: Any) -> Any:
    """Field name -> value, all the way down."""
    if hasattr(message, "get_fields_and_field_types"):
        return {
            name: as_values(getattr(message, name)) for name in message.get_fields_and_field_types()
        }
    if isinstance(message, (list, tuple)):
        return [as_values(one) for one in message]
    if hasattr(message, "tolist"):  # array.array, numpy
        return message.tolist()
    return message


def fill(message: Any, values: dict[str, Any]) -> Any:
    """The message with the given fields; raises AttributeError if there is no such field."""
    types = message.get_fields_and_field_types()
    for name, value in values.items():
        if name not in types:
            raise AttributeError(f"there is no field {name}; the fields are {', '.join(types)}")
        setattr(message, name, _made(getattr(message, name), types[name], value))
    return message


def _made(now: Any, type: str, value: Any) -> Any:
    if isinstance(value, dict):
        return fill(now, value)
    if isinstance(value, list):
        inner = re.search(r"([a-z]\w*)/(\w+)", type)
        if inner is not None:
            cls = getattr(import_module(f"{inner[1]}.msg"), inner[2])
            return [fill(cls(), one) for one in value]
        if "double" in type or "float" in type:
            return [float(one) for one in value]
        return value
    if isinstance(value, int) and not isinstance(value, bool) and type in ("double", "float"):
        return float(value)
    return value
