"""YAML text as plain data, with the place of every key and value kept beside it.

The composer works on the events of ruamel.yaml's parser and keeps a stack of its own, so that
neither a deep nest nor an alias bomb can take it down.
"""

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

from .yaml_scalars import ScalarFault, plain_value, tagged_value

DEEPEST = 100
MOST_NODES = 500_000
"""Nodes of a document, counted as often as aliases repeat them."""
CORE = "tag:yaml.org,2002:"


class YamlFault(Exception):
    """A fault that ends the reading; `start` is an offset in the text."""

    def __init__(
        self, code: str, message: str, start: int, hint: str = "", length: int = 1
    ) -> None:
        super().__init__(message)
        self.code, self.message, self.start = code, message, start
        self.hint, self.length = hint, length


@dataclass(slots=True, eq=False)
class Node:
    """One value: where it stands (offsets), and what stands in it."""

    start: int
    end: int
    value: Any = None
    items: "list[Node] | None" = None
    members: "dict[str, Node] | None" = None
    keys: dict[str, tuple[int, int]] = field(default_factory=dict)
    size: int = 1
    open_key: tuple[str, int, int] | None = None
    anchor: str | None = None


class Composer:
    """Builds nodes from parser events; faults that need not end the reading are collected."""

    def __init__(self) -> None:
        self.faults: list[YamlFault] = []
        self.anchors: dict[str, Node] = {}
        self.stack: list[Node] = []
        self.root: Node | None = None
        self.documents = 0
        self.nodes = 0

    def take(self, event: Any) -> None:
        """Go on by one event."""
        kind = type(event).__name__
        start, end = event.start_mark.index, event.end_mark.index
        if kind == "ScalarEvent":
            node = Node(start, end)
            node.value = self._scalar(event, start, end)
            self._finish(node, event.anchor)
        elif kind in ("MappingStartEvent", "SequenceStartEvent"):
            self._open(event, kind, start, end)
        elif kind in ("MappingEndEvent", "SequenceEndEvent"):
            node = self.stack.pop()
            node.end = end
            self._finish(node, None)
        elif kind == "AliasEvent":
            self._alias(event.anchor, start, end)
        elif kind == "DocumentStartEvent":
            self.documents += 1
            if self.documents > 1:
                raise YamlFault("E107", "a second document begins here", start,
                                "a file holds one protocol; remove the `---`", 3)  # fmt: skip

    def _open(self, event: Any, kind: str, start: int, end: int) -> None:
        if len(self.stack) >= DEEPEST:
            raise YamlFault("E108", f"nested deeper than {DEEPEST} levels", start)
        tag = _core_tag(event)
        wanted = "map" if kind == "MappingStartEvent" else "seq"
        if tag is not None and tag != wanted:
            self._bad_tag(event, start, end)
        mapping = kind == "MappingStartEvent"
        node = Node(start, end, value={} if mapping else [])
        if mapping:
            node.members = {}
        else:
            node.items = []
        node.anchor = event.anchor
        if event.anchor:
            self.anchors[event.anchor] = node
        self.stack.append(node)

    def _scalar(self, event: Any, start: int, end: int) -> Any:
        tag = _core_tag(event)
        try:
            if tag is not None:
                if tag not in ("str", "int", "float", "bool", "null"):
                    self._bad_tag(event, start, end)
                    return event.value
                return tagged_value(tag, event.value)
            return plain_value(event.value) if event.implicit[0] else event.value
        except ScalarFault as fault:
            self.faults.append(YamlFault("E106", str(fault), start, length=end - start))
            return 0

    def _bad_tag(self, event: Any, start: int, end: int) -> None:
        fault = YamlFault("E105", f"the tag {event.tag} is not known here", start,
                          "write the value without a tag", max(1, end - start))  # fmt: skip
        self.faults.append(fault)

    def _alias(self, anchor: str, start: int, end: int) -> None:
        node = self.anchors.get(anchor)
        if node is None:
            raise YamlFault("E104", f"*{anchor} repeats an anchor &{anchor} that is not there", start,
                            "quote the text if it is meant to begin with *", end - start)  # fmt: skip
        if node in self.stack:
            raise YamlFault(
                "E104", f"*{anchor} repeats what it stands in", start, length=end - start
            )
        self._place(node, start, end)

    def _finish(self, node: Node, anchor: str | None) -> None:
        if anchor:
            self.anchors[anchor] = node
        self._place(node, node.start, node.end)

    def _place(self, node: Node, start: int, end: int) -> None:
        """Put a whole node where it belongs: as the root, an item, a key or the value of a key."""
        if not self.stack:
            self.root = self.root or node
            self._count(node, node, start)
            return
        parent = self.stack[-1]
        if parent.items is not None:
            parent.items.append(node)
            parent.value.append(node.value)
        elif parent.open_key is None:
            parent.open_key = (self._key(node, start, end), start, end)
            return
        else:
            self._member(parent, node)
        self._count(parent, node, start)

    def _count(self, parent: Node, node: Node, start: int) -> None:
        if parent is not node:
            parent.size += node.size
        if parent.size > MOST_NODES:
            raise YamlFault(
                "E108", f"more than {MOST_NODES:,} values, counting repeated ones", start
            )

    def _key(self, node: Node, start: int, end: int) -> str:
        if node.items is not None or node.members is not None:
            self.faults.append(YamlFault("E103", "a key is a word, not a list or a mapping", start))
            return f"?{start}"
        return node.value if isinstance(node.value, str) else _key_text(node.value)

    def _member(self, parent: Node, node: Node) -> None:
        assert parent.open_key is not None and parent.members is not None
        key, start, end = parent.open_key
        parent.open_key = None
        if key in parent.members:
            fault = YamlFault("E102", f"the key {key!r} is here a second time", start, length=end - start,
                              hint="keep one of the two")  # fmt: skip
            self.faults.append(fault)
            return
        parent.members[key] = node
        parent.keys[key] = (start, end)
        parent.value[key] = node.value


def _core_tag(event: Any) -> str | None:
    """The short name of a tag, None where there is none."""
    tag = str(event.tag) if event.tag is not None else None
    if tag is None or tag == "!":
        return "str" if tag == "!" else None
    return tag.removeprefix(CORE) if tag.startswith(CORE) else tag


def _key_text(value: Any) -> str:
    words = {None: "null", True: "true", False: "false"}
    return words[value] if value is None or isinstance(value, bool) else str(value)


class Lines:
    """Offsets of a text as lines and columns, both from 1, lines as editors count them."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.starts = list(_line_starts(text))

    def place(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset."""
        line = bisect_right(self.starts, offset)
        return line, offset - self.starts[line - 1] + 1

    def line(self, number: int) -> str:
        """The text of a line, without its end."""
        end = self.starts[number] if number < len(self.starts) else len(self.text)
        return self.text[self.starts[number - 1] : end].rstrip("\r\n")

    def span(self, start: int, end: int) -> tuple[int, int, int]:
        """Line, column and length of what lies between two offsets, on its first line."""
        line, column = self.place(start)
        rest = len(self.line(line).rstrip()) - column + 1
        length = end - start if self.place(max(start, end - 1))[0] == line else rest
        return line, column, max(1, min(length, rest))


def _line_starts(text: str) -> Iterator[int]:
    yield 0
    position = 0
    while True:
        newline, cr = text.find("\n", position), text.find("\r", position)
        if newline < 0 and cr < 0:
            return
        if cr >= 0 and (newline < 0 or cr < newline):
            position = cr + (2 if cr + 1 == newline else 1)
        else:
            position = newline + 1
        yield position
