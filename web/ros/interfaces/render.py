"""Interfaces as the text of `.msg`, `.action` and `.srv` files, with units and ranges as comments."""

from collections.abc import Iterator
from typing import Any

from .kinds import ActionKind, Field, Message, ServiceKind

WIDTH = 100


def message_text(message: Message) -> str:
    """The body of a `.msg` file."""
    return "\n".join([*_comment(message.summary), *_fields(message)]) + "\n"


def file_text(kind: ActionKind | ServiceKind) -> str:
    """The body of an `.action` or `.srv` file."""
    parts = ["\n".join(_fields(part)) for part in kind.parts()]
    top = "\n".join(_comment(kind.summary))
    body = "\n---\n".join(parts)
    return f"{top}\n{body}\n" if top else f"{body}\n"


def _fields(message: Message) -> Iterator[str]:
    for field in message.fields:
        yield from _comment(field.comment)
        for name, value in field.constants:
            yield f"{field.type} {name}={_literal(value)}"
        default = "" if field.default is None else f" {_literal(_of_type(field, field.default))}"
        yield f"{field.written} {field.name}{default}"


def _of_type(field: Field, value: Any) -> Any:
    return float(value) if field.type == "float64" else value


def _literal(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", "\\n") + '"'
    return repr(value)


def _comment(words: str) -> Iterator[str]:
    for line in words.splitlines():
        rest = f"# {line}".rstrip()
        while len(rest) > WIDTH and " " in rest[2:WIDTH]:
            at = rest.rindex(" ", 2, WIDTH)
            yield rest[:at]
            rest = f"# {rest[at + 1 :]}"
        yield rest
