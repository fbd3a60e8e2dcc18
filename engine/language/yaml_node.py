"""One value of a file with its place, and the faults of a file."""

from dataclasses import dataclass
from typing import Any

DEEPEST = 100
MOST_NODES = 500_000
"""Nodes of a document, counting every repetition by an alias."""


class YamlFault(Exception):
    """A fault in a text; `start` is its offset, `first` the offset of what it repeats."""

    def __init__(
        self, code: str, message: str, start: int, hint: str = "", length: int = 1,
        first: int | None = None,
    ) -> None:  # fmt: skip
        super().__init__(message)
        self.code, self.message, self.start = code, message, start
        self.hint, self.length, self.first = hint, length, first


@dataclass(slots=True, eq=False)
class Node:
    """One value: its place (offsets) and its content.

    `plain` is True for a scalar without quotes: only such a scalar can be anything but text.
    """

    start: int
    end: int
    value: Any = None
    items: "list[Node] | None" = None
    members: "dict[str, Node] | None" = None
    keys: "dict[str, tuple[int, int]] | None" = None
    size: int = 1
    plain: bool = False


def too_many(start: int) -> YamlFault:
    """A file with too many values, possibly through aliases."""
    return YamlFault("E108", f"more than {MOST_NODES:,} values, counting repeated ones", start)


def too_deep(start: int) -> YamlFault:
    """A value nested deeper than any protocol needs."""
    return YamlFault("E108", f"nested deeper than {DEEPEST} levels", start)


def key_text(value: Any) -> str:
    """A key as text: `null:` and `1:` are words, too."""
    if isinstance(value, str):
        return value
    words = {None: "null", True: "true", False: "false"}
    return words[value] if value is None or isinstance(value, bool) else str(value)


def twice(key: str, start: int, end: int, first: int) -> YamlFault:
    """A key that its mapping already has."""
    return YamlFault(
        "E102", f"the key {key!r} is used twice", start, "keep one of the two",
        end - start, first,
    )  # fmt: skip


def shown(text: str, most: int = 60) -> str:
    """A piece of a file as messages quote it: on one line, shortened."""
    text = " ".join(text.split())
    return text if len(text) <= most else text[: most - 3] + "..."
