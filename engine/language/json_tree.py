"""JSON as the same nodes as YAML; tabs, `\\/` and surrogate pairs have their JSON meaning."""

import re
from typing import Any

from .yaml_node import DEEPEST, MOST_NODES, Node, YamlFault, shown, too_deep, too_many, twice
from .yaml_scalars import ScalarFault, plain_value, whole_text

SPACE = re.compile(r"[ \t\r\n]*+")
STRING = re.compile(r'"([^"\\\x00-\x1f]*+(?:\\.[^"\\\x00-\x1f]*+)*+)"')
NUMBER = re.compile(r"-?(?:0|[1-9]\d*+)(?:\.\d++)?(?:[eE][-+]?\d++)?(?![\w.+-])")
WORD = re.compile(r"[^\s,:\[\]{}\"']++")
UNIT = re.compile(r"[^\W\d_]\w*")
ESCAPE = re.compile(r"\\(?:u([0-9A-Fa-f]{4})|(.))")
ESCAPES = {
    '"': '"', "\\": "\\", "/": "/", "b": "\b", "f": "\f", "n": "\n", "r": "\r", "t": "\t",
}  # fmt: skip
WORDS = {"true": True, "false": False, "null": None}
OTHER_WORDS = {
    "True": "true", "TRUE": "true", "False": "false", "FALSE": "false", "None": "null",
    "Null": "null", "NULL": "null", "undefined": "null", "yes": "true", "no": "false",
    "on": "true", "off": "false",
}  # fmt: skip
NOT_FINITE = {"NaN", "Infinity", "-Infinity", "nan", "inf", "-inf"}


class JsonReader:
    """Reads one JSON value; a fatal fault is raised, others are collected."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.faults: list[YamlFault] = []

    def read(self) -> Node | None:
        """The root; None where there is only whitespace."""
        pos = self.space(0)
        if pos == len(self.text):
            return None
        node = self.value(pos, 0)
        pos = self.space(node.end)
        if pos < len(self.text):
            raise self.extra(pos)
        return node

    def space(self, pos: int) -> int:
        """The next position after whitespace; raises for comments, which JSON does not have."""
        pos = SPACE.match(self.text, pos).end()  # type: ignore[union-attr]
        if self.text.startswith(("//", "/*", "#"), pos):
            raise _fault("JSON has no comments", pos,
                         "remove it, or save the file as .yaml and write `# ...`")  # fmt: skip
        return pos

    def value(self, pos: int, depth: int) -> Node:
        first = self.text[pos : pos + 1]
        if first in ("{", "["):
            if depth >= DEEPEST:
                raise too_deep(pos)
            return self.mapping(pos, depth) if first == "{" else self.array(pos, depth)
        if first == '"':
            return self.string(pos)
        return self.word(pos)

    def array(self, opening: int, depth: int) -> Node:
        node = Node(opening, opening, value=[], items=[])
        pos = self.space(opening + 1)
        while self.text[pos : pos + 1] != "]":
            item = self.value(self.there(pos, opening, "]"), depth + 1)
            node.items.append(item)  # type: ignore[union-attr]
            node.value.append(item.value)
            pos = self.next(item, node, "]")
        node.end = pos + 1
        return node

    def mapping(self, opening: int, depth: int) -> Node:
        node = Node(opening, opening, value={}, members={}, keys={})
        pos = self.space(opening + 1)
        while self.text[pos : pos + 1] != "}":
            key = self.key(self.there(pos, opening, "}"))
            colon = self.space(key.end)
            if self.text[colon : colon + 1] != ":":
                raise _fault("a `:` is missing after this key", pos, 'write "key": value',
                             key.end - pos)  # fmt: skip
            member = self.value(self.there(self.space(colon + 1), opening, "}"), depth + 1)
            self.member(node, key, member)
            pos = self.next(member, node, "}")
        node.end = pos + 1
        return node

    def member(self, node: Node, key: Node, member: Node) -> None:
        assert node.members is not None and node.keys is not None
        if key.value in node.members:
            first = node.keys[key.value][0]
            self.faults.append(twice(key.value, key.start, key.end, first))
            return
        node.members[key.value] = member
        node.keys[key.value] = (key.start, key.end)
        node.value[key.value] = member.value

    def key(self, pos: int) -> Node:
        if self.text[pos] != '"':
            if single := re.compile(r"'([^'\n]*)'").match(self.text, pos):
                raise _fault("JSON has no single quotes", pos,
                             f'write "{shown(single[1])}", with double quotes here and elsewhere',
                             len(single[0]))  # fmt: skip
            match = WORD.match(self.text, pos)
            word = match[0] if match else self.text[pos]
            raise _fault("a key without double quotes", pos,
                         f'write "{shown(word)}": ...', len(word))  # fmt: skip
        return self.string(pos)

    def next(self, item: Node, parent: Node, closing: str) -> int:
        """The position of the next item, or of the closing bracket."""
        parent.size += item.size
        if parent.size > MOST_NODES:
            raise too_many(item.start)
        pos = self.space(item.end)
        here = self.text[pos : pos + 1]
        if here == ",":
            after = self.space(pos + 1)
            if self.text[after : after + 1] in ("}", "]"):
                raise _fault(
                    "a comma after the last item", pos, "remove it: JSON does not allow one here"
                )
            return after
        if here != closing:
            self.there(pos, parent.start, closing)
            if here in "}]":
                raise _fault(f"{here} does not close the {self.text[parent.start]} of"
                             f" this {_what(closing)}", pos, f"write {closing}")  # fmt: skip
            raise self.missing(item, pos, closing)
        return pos

    def missing(self, item: Node, pos: int, closing: str) -> YamlFault:
        unit = UNIT.match(self.text, pos)
        if item.plain and unit is not None:
            written = shown(self.text[item.start : unit.end()])
            return _fault("a quantity needs double quotes", item.start, f'write "{written}"',
                          unit.end() - item.start)  # fmt: skip
        return _fault(f"a comma or {closing} is missing before this", pos,
                      "write a comma between two items")  # fmt: skip

    def there(self, pos: int, opening: int, closing: str) -> int:
        """The position; raises for the unclosed bracket if the text ends there."""
        if pos >= len(self.text):
            message = f"a bracket that is never closed; {closing} is missing"
            raise _fault(message, opening, f"close it with {closing}; was the file cut off?")
        return pos

    def string(self, pos: int) -> Node:
        match = STRING.match(self.text, pos)
        if match is None:
            raise self.broken_string(pos)
        text = match[1]
        if "\\" in text:
            text = ESCAPE.sub(lambda escape: self.escaped(escape, pos + 1), text)
        try:
            return Node(pos, match.end(), whole_text(text))
        except ScalarFault as fault:
            raise _fault(str(fault), pos, length=match.end() - pos) from None

    def escaped(self, escape: re.Match[str], start: int) -> str:
        if escape[1] is not None:
            return chr(int(escape[1], 16))
        if escape[2] not in ESCAPES:
            raise _fault(f"a backslash with {escape[2]!r} means nothing in JSON",
                         start + escape.start(), r"write \\ for a backslash", 2)  # fmt: skip
        return ESCAPES[escape[2]]

    def broken_string(self, pos: int) -> YamlFault:
        match = re.compile(r'"(?:[^"\\\x00-\x1f]|\\.)*').match(self.text, pos)
        end = match.end() if match is not None else pos
        if end < len(self.text) and self.text[end] == "\t":
            return _fault("a tab inside text; in JSON write \\t", end)
        return _fault("a quote that is never closed on its line", pos,
                      'close it with "; write a line break inside text as \\n',
                      max(1, end - pos))  # fmt: skip

    def word(self, pos: int) -> Node:
        """Numbers, true, false and null."""
        number = NUMBER.match(self.text, pos)
        if number is not None:
            try:
                return Node(pos, number.end(), plain_value(number[0]), plain=True)
            except ScalarFault as fault:
                self.faults.append(YamlFault("E106", str(fault), pos, length=number.end() - pos))
                return Node(pos, number.end(), 0)
        match = WORD.match(self.text, pos)
        word = match[0] if match is not None else ""
        if word in WORDS:
            return Node(pos, pos + len(word), WORDS[word], plain=True)
        raise self.no_value(pos, word)

    def no_value(self, pos: int, word: str) -> YamlFault:
        if self.text[pos] == "'":
            return _fault("single quotes; JSON has only double quotes", pos, 'write "..."')
        if not word:
            return _fault(f"a {self.text[pos]} where a value should be", pos)
        if word in NOT_FINITE:
            message = f"{word} is not a number that a device can use"
            return YamlFault("E106", message, pos, "leave the key out, or write null", len(word))
        if word in OTHER_WORDS:
            return _fault(
                f"{word} is not valid in JSON", pos, f"write {OTHER_WORDS[word]}", len(word)
            )
        if word[0].isdigit() or word[0] in "+-.":
            hint = (
                "use only digits, a point and e, without a leading + or 0; a quantity needs quotes"
            )
            return _fault(f"{shown(word)} is not a valid JSON number", pos, hint, len(word))
        return _fault(
            f"{shown(word)} needs double quotes", pos, f'write "{shown(word)}"', len(word)
        )

    def extra(self, pos: int) -> YamlFault:
        return _fault("there is something after the end of the JSON value", pos,
                      "a file holds one value; check whether a bracket is closed too early")  # fmt: skip


def _what(closing: str) -> Any:
    return "list" if closing == "]" else "mapping"


def _fault(message: str, start: int, hint: str = "", length: int = 1) -> YamlFault:
    return YamlFault("E101", message, start, hint, length)
