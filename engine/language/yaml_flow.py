"""Lists and mappings between brackets, as far as they are nothing out of the ordinary."""

import re

from .yaml_node import DEEPEST, Node, key_text
from .yaml_pieces import START, Scalars, Unusual

FLOW_REST = (
    r"(?:[^\s:,\[\]{}\#\0]++|(?<=\w):(?=\w)|(?<=[^\s,\[\]{}])\#|[ ]++(?=[^\s:,\[\]{}\#\0]))*+"
)
FLOW_PLAIN = re.compile(rf"(?:{START}|-(?=[\w.])){FLOW_REST}")
MORE_FLOW_PLAIN = re.compile(FLOW_REST)
LONGEST_KEY = 1000


class Flow(Scalars):
    """`[...]` and `{...}`, which may go over several lines."""

    def flow(self, pos: int, depth: int) -> tuple[Node, int]:
        """`[...]` or `{...}`."""
        if depth >= DEEPEST:
            raise Unusual
        if self.text[pos] == "[":
            return self.flow_list(pos, depth)
        return self.flow_mapping(pos, depth)

    def flow_value(self, pos: int, depth: int) -> tuple[Node, int]:
        """Something between brackets, and where it ends."""
        first = self.text[pos]
        if first in "[{":
            return self.flow(pos, depth + 1)
        if first in "\"'":
            node = self.quoted(pos)
            return node, node.end
        match = FLOW_PLAIN.match(self.text, pos)
        if match is None:
            raise Unusual
        text, end = match[0], match.end()
        if self.text[end] in " \r\n":
            text, end = self.folded(text, end, -1, MORE_FLOW_PLAIN)
        return Node(pos, end, self.value(text), plain=True), end

    def flow_list(self, pos: int, depth: int) -> tuple[Node, int]:
        items: list[Node] = []
        node = Node(pos, pos, [], items)
        pos = self.gap(pos + 1)
        while self.text[pos] != "]":
            item, pos = self.flow_value(pos, depth)
            self.put(node, item)
            items.append(item)
            node.value.append(item.value)
            pos = self.next(pos, "]")
        node.end = pos + 1
        return node, pos + 1

    def flow_mapping(self, pos: int, depth: int) -> tuple[Node, int]:
        members: dict[str, Node] = {}
        keys: dict[str, tuple[int, int]] = {}
        node = Node(pos, pos, {}, None, members, keys)
        pos = self.gap(pos + 1)
        while self.text[pos] != "}":
            key, start, end, pos = self.flow_key(pos, depth)
            if key in members or key == "<<":
                raise Unusual
            inner = self.gap(pos)
            if self.text[inner] in ",}":
                member = Node(pos, pos, plain=True)
            else:
                member, inner = self.flow_value(inner, depth)
            self.put(node, member)
            members[key], keys[key], node.value[key] = member, (start, end), member.value
            pos = self.next(inner, "}")
        node.end = pos + 1
        return node, pos + 1

    def flow_key(self, pos: int, depth: int) -> tuple[str, int, int, int]:
        """A key, where it begins and ends, and the place behind its colon."""
        if self.text[pos] in "{[":
            raise Unusual
        node, end = self.flow_value(pos, depth)
        if end - pos > LONGEST_KEY or "\n" in self.text[pos:end]:
            raise Unusual
        colon = end
        while self.text[colon] == " ":
            colon += 1
        if self.text[colon] in ",}":
            return key_text(node.value), pos, end, end
        if self.text[colon] != ":" or (node.plain and self.text[colon + 1] not in " \r\n"):
            raise Unusual
        return key_text(node.value), pos, end, colon + 1

    def next(self, pos: int, closing: str) -> int:
        """The place of the next item, or of the bracket that closes."""
        pos = self.gap(pos)
        if self.text[pos] == ",":
            return self.gap(pos + 1)
        if self.text[pos] != closing:
            raise Unusual
        return pos
