"""The Python classes of the installed ROS interfaces, checked against the lab's contracts."""

import importlib
import re
from typing import Any

from ..interfaces.fault import RosFault
from ..interfaces.kinds import ActionKind, Field, Message, ServiceKind

IDL = {"bool": "boolean", "float32": "float", "float64": "double"}
MAKE = "make and build them: `labrun ros --interfaces DIR`, then `colcon build` there, then source its setup"


def built(kind: ActionKind | ServiceKind | Message) -> Any:
    """The class of an interface; raises RosFault if missing, or from another contract."""
    try:
        module = importlib.import_module(f"{kind.package}.{kind.group}")
        found = getattr(module, kind.name)
    except ImportError as fault:
        raise RosFault(f"the ROS package {kind.package} is missing ({fault}); {MAKE}") from fault
    except AttributeError as fault:
        raise RosFault(f"the ROS package {kind.package} has no {kind.type}; {MAKE}") from fault
    for message, cls in _parts(kind, found):
        _compare(message, cls, kind.type)
    return found


def nested_class(message: Message) -> Any:
    """The class of a message within another."""
    return getattr(importlib.import_module(f"{message.package}.{message.group}"), message.name)


def _parts(kind: ActionKind | ServiceKind | Message, found: Any) -> list[tuple[Message, Any]]:
    if isinstance(kind, ActionKind):
        return list(zip(kind.parts(), (found.Goal, found.Result, found.Feedback), strict=True))
    if isinstance(kind, ServiceKind):
        return list(zip(kind.parts(), (found.Request, found.Response), strict=True))
    return [(kind, found)]


def _compare(message: Message, cls: Any, type: str) -> None:
    wanted = {field.name: _idl(field) for field in message.fields}
    there = {
        n: t
        for n, t in cls.get_fields_and_field_types().items()
        if n != "structure_needs_at_least_one_member"
    }
    differs = sorted({*wanted.items()} ^ {*there.items()})
    if differs:
        raise RosFault(f"{type} is built from another contract ({differs[0][0]} differs); {MAKE}")
    if list(wanted) != list(there):  # the order is the wire format: values would land elsewhere
        raise RosFault(
            f"{type} is built from another contract: its fields are in the order "
            f"{', '.join(there)}, here {', '.join(wanted)}; {MAKE}"
        )
    for field in message.fields:
        if field.message is not None:
            _compare(field.message, nested_class(field.message), type)


def _idl(field: Field) -> str:
    """A field's type in rosidl notation: `sequence<double, 1>`."""
    one = IDL.get(field.type, field.type)
    if field.message is not None:
        one = f"{field.message.package}/{field.message.name}"
    elif field.bound is not None:
        one = f"string<{field.bound}>"
    if not field.array:
        return one
    size = re.fullmatch(r"\[(<=)?(\d*)\]", field.array)
    assert size is not None
    if not size[2]:
        return f"sequence<{one}>"
    return f"sequence<{one}, {size[2]}>" if size[1] else f"{one}[{size[2]}]"
