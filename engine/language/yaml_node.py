"""One value of a file with its place, and what can end the reading of one."""

from dataclasses import dataclass
from typing import Any

DEEPEST = 100
MOST_NODES = 500_000
"""Nodes of a document, counted as often as aliases repeat them."""


class YamlFault(Exception):
    """A fault of a text; `start` is an offset in it, `first` that of what it repeats."""

    def __init__(
        self, code: str, message: str, start: int, hint: str = "", length: int = 1,
        first: int | None = None,
    ) -> None:  # fmt: skip
        super().__init__(message)
        self.code, self.message, self.start = code, message, start
        self.hint, self.length, self.first = hint, length, first


@dataclass(slots=True, eq=False)
class Node:
    """One value: where it stands (offsets), and what stands in it.

    `plain` is True of a scalar without quotes: only such a one may mean something else than text.
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
    """A file with more values than anybody writes, or one that aliases blow up."""
    return YamlFault("E108", f"more than {MOST_NODES:,} values, counting repeated ones", start)


def too_deep(start: int) -> YamlFault:
    """A value within more lists and mappings than any protocol needs."""
    return YamlFault("E108", f"nested deeper than {DEEPEST} levels", start)


def key_text(value: Any) -> str:
    """A key as text: `null:` and `1:` are words here, too."""
    if isinstance(value, str):
        return value
    words = {None: "null", True: "true", False: "false"}
    return words[value] if value is None or isinstance(value, bool) else str(value)


def twice(key: str, start: int, end: int, first: int) -> YamlFault:
    """A key that its mapping has already."""
    return YamlFault(
        "E102", f"the key {key!r} is here a second time", start, "keep one of the two",
        end - start, first,
    )  # fmt: skip


def shown(text: str, most: int = 60) -> str:
    """A piece of a file as a sentence quotes it: on one line, not longer than one."""
    text = " ".join(text.split())
    return text if len(text) <= most else text[: most - 3] + "..."
