"""The YAML that people write most, read ten times as fast as a whole parser can.

Whatever is out of the ordinary (anchors, tags, tabs, directives, and every fault) raises Unusual:
then the text is read by ruamel.yaml, which knows all of YAML and says where a fault is. A test
holds the two against each other.
"""

import re

from .yaml_flow import LONGEST_KEY, Flow
from .yaml_node import DEEPEST, Node, key_text
from .yaml_pieces import Unusual

FOREIGN = re.compile(
    "\r(?!\n)|^(?:---|\\.\\.\\.)(?=\\s|\\Z)|\u2028|\u2029|\x85|"
    "[^\t\n\r\x20-\x7e\xa0-\ud7ff\ue000-\ufefe\uff00-\ufffd\U00010000-\U0010ffff]",
    re.MULTILINE,
)
"""Other line ends, more documents, and characters that no text editor shows."""
OPENING = re.compile(r"(?:[ ]*(?:#[^\r\n]*)?\r?\n)*---[ ]*(?:[ ]#[^\r\n]*)?\r?\n")
KEY = re.compile(r"([A-Za-z_][A-Za-z0-9_]*+):(?=[ \r\n])")
OTHER_KEY = re.compile(
    r"""(?:"(?P<double>[^"\\\r\n]*+)"|'(?P<single>[^'\r\n]*+)'"""
    r"""|(?P<plain>(?:[^\s\-?:,\[\]{}\#&*!|>'"%@`\0]|[\-?:](?=[^\s\0]))"""
    r"""(?:[^\s:\#\0]|:(?=[^\s\0])|(?<=\S)\#|[ ](?=[^\s:\#\0]))*+))"""
    r"""[ ]*+:(?=[ \r\n])"""
)


def read_fast(text: str) -> Node | None:
    """The root of a text; None where it is empty. Raises Unusual, or YamlFault for too much of it."""
    opening = OPENING.match(text)
    begin = opening.end() if opening is not None else 0
    if FOREIGN.search(text, begin):
        raise Unusual
    return _Blocks(text).read(begin)


class _Blocks(Flow):
    """Block mappings and lists: what a mapping or list is, its column says."""

    def read(self, begin: int) -> Node | None:
        pos = self.gap(begin)
        if pos >= self.length:
            return None
        node, pos = self.block(pos, self.column(pos), -1, 0)
        if pos < self.length:
            raise Unusual
        return node

    def block(self, pos: int, column: int, indent: int, depth: int) -> tuple[Node, int]:
        """What stands at a place, and where the next thing stands; `indent` is the parent's."""
        if depth >= DEEPEST:
            raise Unusual
        text = self.text
        if text[pos] == "-" and text[pos + 1] in " \r\n":
            return self.sequence(pos, column, depth)
        match = KEY.match(text, pos) or OTHER_KEY.match(text, pos)
        if match is not None:
            return self.mapping(pos, column, depth, match)
        return self.inline(pos, indent, depth)

    def inline(self, pos: int, indent: int, depth: int) -> tuple[Node, int]:
        """A scalar, or a list or mapping between brackets, after which the line must end."""
        if self.text[pos] in "{[":
            node, pos = self.flow(pos, depth)
            return node, self.line_end(pos)
        return self.scalar(pos, indent)

    def sequence(self, pos: int, column: int, depth: int) -> tuple[Node, int]:
        """`- item` lines that all begin in this column."""
        text = self.text
        node = Node(pos, pos, value=[], items=[])
        while True:
            inner = pos + 1
            while text[inner] == " ":
                inner += 1
            if text[inner] in "\r\n#":
                item, pos = self.below(pos + 1, column, depth)
            else:
                item, pos = self.block(inner, column + inner - pos, column, depth + 1)
            self.put(node, item)
            node.items.append(item)  # type: ignore[union-attr]
            node.value.append(item.value)
            if pos >= self.length or self.column(pos) < column:
                break
            if self.column(pos) > column:
                raise Unusual
            if text[pos] != "-" or text[pos + 1] not in " \r\n":
                break  # a key, after a list that stands in the column of its mapping
        node.end = min(pos, self.length)
        return node, pos

    def mapping(self, pos: int, column: int, depth: int, match: re.Match[str]) -> tuple[Node, int]:
        """`key: value` lines that all begin in this column."""
        text = self.text
        members: dict[str, Node] = {}
        keys: dict[str, tuple[int, int]] = {}
        values: dict[str, object] = {}
        node = Node(pos, pos, values, None, members, keys)
        while True:
            key, end = self.key(match)
            if key in members:
                raise Unusual
            after = inner = match.end()
            while text[inner] == " ":
                inner += 1
            if text[inner] in "\r\n#":
                member, after = self.below(after, column, depth, in_mapping=True)
            else:
                member, after = self.inline(inner, column, depth + 1)
            self.put(node, member)
            members[key], keys[key], values[key] = member, (pos, end), member.value
            pos = after
            if pos >= self.length or self.column(pos) < column:
                break
            found = KEY.match(text, pos) or OTHER_KEY.match(text, pos)
            if found is None or self.column(pos) > column:
                raise Unusual
            match = found
        node.end = min(pos, self.length)
        return node, pos

    def below(
        self, pos: int, column: int, depth: int, *, in_mapping: bool = False
    ) -> tuple[Node, int]:
        """What a key or dash that ends its line is followed by; nothing is null."""
        after = self.gap(pos)
        if after < self.length:
            inner = self.column(after)
            if inner > column:
                return self.block(after, inner, column, depth + 1)
            dash = self.text[after] == "-" and self.text[after + 1] in " \r\n"
            if in_mapping and inner == column and dash:
                return self.sequence(after, inner, depth + 1)
        return Node(pos, pos, plain=True), after

    def key(self, match: re.Match[str]) -> tuple[str, int]:
        """The text of a key and where it ends."""
        if match.re is KEY:
            key, end, plain = match[1], match.end() - 1, True
        else:
            group = match.lastgroup or ""
            plain = group == "plain"
            key, end = match[group], match.end(group) + (not plain)
        if end - match.start() > LONGEST_KEY or key == "<<":
            raise Unusual
        return key_text(self.value(key)) if plain else key, end
