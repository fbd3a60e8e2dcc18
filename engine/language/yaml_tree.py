"""Read YAML text as plain data, with the place of every key and value.

The composer works on the events of ruamel.yaml's or libyaml's parser and keeps its own stack, so
that neither deep nesting nor an alias bomb can crash it.
"""

from dataclasses import dataclass, field
from typing import Any

from .yaml_merge import MERGE, merge
from .yaml_node import (
    DEEPEST,
    MOST_NODES,
    Node,
    YamlFault,
    key_text,
    shown,
    too_deep,
    too_many,
    twice,
)  # fmt: skip
from .yaml_scalars import ScalarFault, plain_value, tagged_value, whole_text

CORE = "tag:yaml.org,2002:"


@dataclass(slots=True, eq=False)
class Open:
    """A list or mapping that has not ended yet, with the key that awaits its value."""

    node: Node
    key: tuple[Node, int, int] | None = None
    merges: list[tuple[Node, int]] = field(default_factory=list)
    braces: bool = False

    @property
    def awaits_key(self) -> bool:
        """True for a mapping whose next value is a key."""
        return self.node.items is None and self.key is None


class Composer:
    """Builds nodes from parser events; non-fatal faults are collected."""

    def __init__(self, text: str = "") -> None:
        self.text = text
        self.faults: list[YamlFault] = []
        self.anchors: dict[str, Node] = {}
        self.unrepeated: dict[str, tuple[int, int]] = {}
        self.stack: list[Open] = []
        self.root: Node | None = None
        self.documents = 0

    def take(self, event: Any) -> None:
        """Process one event."""
        kind = type(event).__name__
        start, end = event.start_mark.index, event.end_mark.index
        if kind == "ScalarEvent":
            node = self._scalar(event, start, end)
            if event.anchor:
                self.anchors[event.anchor] = node
                self.unrepeated[event.anchor] = (start, end)
            self._place(node, start, end)
        elif kind in ("MappingStartEvent", "SequenceStartEvent"):
            self._open(event, kind, start, end)
        elif kind in ("MappingEndEvent", "SequenceEndEvent"):
            self._close(end)
        elif kind == "AliasEvent":
            self._alias(event.anchor, start, end)
        elif kind == "DocumentStartEvent":
            self._document(event, start)

    def ended(self) -> None:
        """The text has been read: an anchor of text that nothing repeats was meant as text."""
        for anchor, (start, end) in self.unrepeated.items():
            self.faults.append(YamlFault(
                "W104", f"YAML reads &{anchor} as an anchor, not as part of this text", start,
                "put the text in quotes; if it is an anchor, nothing repeats it", end - start,
            ))  # fmt: skip

    def _document(self, event: Any, start: int) -> None:
        self.documents += 1
        if self.documents > 1:
            hint = "a file holds one protocol, lab or contract; remove the `---` or `...` before it"
            raise YamlFault("E107", "a second document begins here", start, hint, 3)
        if event.tags or (event.version is not None and tuple(event.version) != (1, 2)):
            at = self.text.find("%") if self.text[:1] == "%" else self.text.find("\n%") + 1
            self.faults.append(YamlFault(
                "E105", "a directive (`%...`) that would change how the file is read", max(at, 0),
                "remove the line: labrun reads YAML 1.2 without tags",
            ))  # fmt: skip

    def _open(self, event: Any, kind: str, start: int, end: int) -> None:
        if len(self.stack) >= DEEPEST:
            raise too_deep(start)
        mapping = kind == "MappingStartEvent"
        tag = _core_tag(event)
        if tag is not None and tag != ("map" if mapping else "seq"):
            self._bad_tag(event, start, end)
        node = Node(start, end, value={} if mapping else [])
        if mapping:
            node.members, node.keys = {}, {}
        else:
            node.items = []
        if event.anchor:
            self.anchors[event.anchor] = node
        self.stack.append(Open(node))

    def _close(self, end: int) -> None:
        closed = self.stack.pop()
        closed.node.end = end
        if closed.merges:
            self.faults += merge(closed.node, closed.merges)
        if closed.braces:
            self._braces(closed.node)
        self._place(closed.node, closed.node.start, end)

    def _scalar(self, event: Any, start: int, end: int) -> Node:
        plain = event.implicit[0] and not event.style
        node = Node(start, end, event.value, None, None, None, 1, plain)
        tag = _core_tag(event) if event.tag is not None else None
        try:
            if plain and tag is None:
                node.value = plain_value(event.value)
            elif tag in ("str", "int", "float", "bool", "null"):
                node.value = tagged_value(tag, event.value)
            elif tag is not None:
                self._bad_tag(event, start, end)
            if isinstance(node.value, str) and not node.value.isascii():
                node.value = whole_text(node.value)
        except ScalarFault as fault:
            self.faults.append(YamlFault("E106", str(fault), start, length=end - start))
            # As a bound it bounds nothing: with 0 another value would be above it, as well.
            key = self.stack[-1].key if self.stack else None
            is_bound = key is not None and key[0].value in ("minimum", "maximum")
            node.value = (None if is_bound else 0) if plain else ""
        return node

    def _bad_tag(self, event: Any, start: int, end: int) -> None:
        mark = self.text.find("!", start, end) if end > start else start
        name = str(event.tag).removeprefix(CORE)
        fault = YamlFault("E105", f"unknown tag {name}", max(start, mark),
                          "write the value without a tag, or quote text that begins with `!`",
                          max(1, end - start))  # fmt: skip
        self.faults.append(fault)

    def _alias(self, anchor: str, start: int, end: int) -> None:
        node = self.anchors.get(anchor)
        self.unrepeated.pop(anchor, None)
        if node is None:
            what = f"*{anchor} refers to an anchor &{anchor} that does not exist"
            if not anchor.isidentifier():
                what = "YAML reads text that begins with * as an alias"
            raise YamlFault("E104", what, start, "put the text in quotes if the * belongs to it",
                            end - start)  # fmt: skip
        if any(node is open_.node for open_ in self.stack):
            raise YamlFault(
                "E104", f"*{anchor} repeats something that contains it", start, length=end - start
            )
        self._place(node, start, end)

    def _place(self, node: Node, start: int, end: int) -> None:
        """Put a complete node in its place: as the root, an item, a key or the value of a key."""
        if not self.stack:
            self.root = self.root or node
            return
        open_ = self.stack[-1]
        parent = open_.node
        if parent.items is not None:
            parent.items.append(node)
            parent.value.append(node.value)
        elif open_.key is None:
            open_.key = (node, start, end)
            return
        else:
            self._member(open_, node)
        parent.size += node.size
        if parent.size > MOST_NODES:
            raise too_many(start)

    def _member(self, open_: Open, node: Node) -> None:
        assert open_.key is not None
        (key_node, start, end), open_.key = open_.key, None
        parent = open_.node
        assert parent.members is not None and parent.keys is not None
        if key_node.items is not None or key_node.members is not None:
            self._odd_key(open_, key_node, start)
            return
        if key_node.plain and key_node.value == MERGE:
            open_.merges.append((node, start))
            return
        if key_node.value is None and (written := self.text[start:end].strip()) != "null":
            message = (
                f"a key is a word, not {f'`{written}`, which is null' if written else 'nothing'}"
            )
            self.faults.append(YamlFault("E103", message, start, length=end - start))
            return
        key = key_text(key_node.value)
        if key in parent.members:
            self.faults.append(twice(key, start, end, parent.keys[key][0]))
            return
        parent.members[key] = node
        parent.keys[key] = (start, end)
        parent.value[key] = node.value

    def _odd_key(self, open_: Open, key: Node, start: int) -> None:
        """A list or mapping as a key is always a mistake; `{{ x }}` is an expression without `$`."""
        if key.members is not None and open_.node.start == start - 1:
            open_.braces = True
            return
        self.faults.append(YamlFault("E103", "a key is a word, not a list or a mapping", start))

    def _braces(self, node: Node) -> None:
        """Read `{{ x }}` as `${{ x }}`, so that the missing `$` is reported only once."""
        written = self.text[node.start : node.end]
        fault = YamlFault("E109", "YAML reads `{{ ... }}` without a `$` as a mapping in a mapping",
                          node.start, f'write "${shown(written)}", with the quotes',
                          len(written))  # fmt: skip
        self.faults.append(fault)
        node.value, node.members, node.keys = "$" + written, None, None


def _core_tag(event: Any) -> str | None:
    """The short name of a tag; None without a tag."""
    tag = str(event.tag) if event.tag is not None else None
    if tag is None or tag == "!":
        return "str" if tag == "!" else None
    return tag.removeprefix(CORE) if tag.startswith(CORE) else tag
