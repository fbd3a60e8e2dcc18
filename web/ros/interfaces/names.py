"""Valid ROS names, made from names that may not be valid in ROS.

ROS 2: fields are lower case, types CamelCase, constants upper case; no name has two underscores in
a row or ends with one (design.ros2.org: "Interface Definition", "Topic and Service Names").
"""

import keyword
import re
from collections.abc import Collection

WORDS = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z0-9]+|[0-9]+")
CPP = {
    "alignas", "alignof", "and", "asm", "auto", "bool", "break", "case", "catch", "char", "class",
    "const", "constexpr", "continue", "default", "delete", "do", "double", "else", "enum",
    "explicit", "export", "extern", "false", "float", "for", "friend", "goto", "if", "inline",
    "int", "long", "mutable", "namespace", "new", "not", "nullptr", "operator", "or", "private",
    "protected", "public", "register", "requires", "return", "short", "signed", "sizeof",
    "static", "struct", "switch", "template", "this", "throw", "true", "try", "typedef",
    "typename", "union", "unsigned", "using", "virtual", "void", "volatile", "while", "xor",
}  # fmt: skip
PYTHON = frozenset(word.lower() for word in keyword.kwlist)
TOPIC = re.compile(r"^(/[A-Za-z](?:_?[A-Za-z0-9])*)+$")
"""A full topic, action or service name."""


def words(name: str) -> list[str]:
    """`move_to`, `moveTo` and `Move To` are all [move, to]."""
    return [word.lower() for word in WORDS.findall(name)]


def field_name(name: str, taken: Collection[str] = ()) -> str:
    """A valid field name that is not already in use."""
    plain = "_".join(words(name)) or "value"
    if plain[0].isdigit() or plain in CPP or plain in PYTHON:
        plain = f"value_{plain}"
    return _free(plain, taken)


def type_name(*names: str) -> str:
    """`GantryMoveTo` from `gantry@1` and `move_to`; a major version other than 1 is kept."""
    return "".join(_camel(name.removesuffix("@1")) for name in names)


def constant_name(field: str, value: object, taken: Collection[str] = ()) -> str:
    """`STATE_IDLE` for the value `idle` of the field `state`."""
    said = "_".join(words(str(value))) or "empty"
    if isinstance(value, (int, float)) and value < 0:
        said = f"minus_{said}"
    return _free(f"{field}_{said}", [name.lower() for name in taken]).upper()


def topic_token(name: str, taken: Collection[str] = ()) -> str:
    """A device's name as a part of a topic: letters of either case, digits, single underscores."""
    plain = re.sub(r"[^A-Za-z0-9]+", "_", name).strip("_") or "device"
    if plain[0].isdigit():
        plain = f"device_{plain}"
    return _free(plain, taken)


def _camel(name: str) -> str:
    said = "".join(word.capitalize() for word in words(name)) or "Value"
    return f"V{said}" if said[0].isdigit() else said


def _free(name: str, taken: Collection[str]) -> str:
    if name not in taken:
        return name
    number = 2
    while f"{name}_{number}" in taken:
        number += 1
    return f"{name}_{number}"
