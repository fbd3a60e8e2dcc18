"""Format JSON protocols: numbers and texts unchanged, short values on one line."""

from ..language.source import Source
from ..language.yaml_node import Node

WIDEST = 88


def format_json(source: Source) -> str:
    """The formatted text of a JSON file."""
    assert source.root is not None
    return _shown(source.root, source.text, 0) + "\n"


def _shown(node: Node, text: str, indent: int) -> str:
    short = _in_a_line(node, text, WIDEST - indent)
    if short is not None:
        return short
    inner = indent + 2
    if node.items is not None:
        rows = [_shown(item, text, inner) for item in node.items]
        opening, closing = "[]"
    else:
        assert node.members is not None
        rows = [
            _key(node, key, text) + _shown(node.members[key], text, inner) for key in node.members
        ]
        opening, closing = "{}"
    if not rows:
        return text[node.start : node.end]
    body = (",\n").join(" " * inner + row for row in rows)
    return f"{opening}\n{body}\n{' ' * indent}{closing}"


def _in_a_line(node: Node, text: str, room: int) -> str | None:
    """The value on one line; None if it does not fit."""
    if node.items is None and node.members is None:
        return text[node.start : node.end]
    if node.size > room:
        return None
    if node.items is not None:
        rows = [_in_a_line(item, text, room) for item in node.items]
        opening, closing = "[]"
    else:
        members = (node.members or {}).items()
        rows = [_with_key(node, key, _in_a_line(item, text, room), text) for key, item in members]
        opening, closing = "{}"
    if any(row is None for row in rows):
        return None
    line = opening + ", ".join(row for row in rows if row is not None) + closing
    return line if len(line) <= room else None


def _with_key(node: Node, key: str, row: str | None, text: str) -> str | None:
    return None if row is None else _key(node, key, text) + row


def _key(node: Node, key: str, text: str) -> str:
    start, end = (node.keys or {})[key]
    return text[start:end] + ": "
