"""The values that lines of YAML end with: texts with and without quotes, and block scalars."""

import re
from typing import Any

from .yaml_node import MOST_NODES, Node, too_many
from .yaml_scalars import ScalarFault, plain_value

START = r"""[^\s\-?:,\[\]{}\#&*!|>'"%@`\0]"""
REST = r"""(?:[^\s:\#\0]++|:(?=[^\s\0])|(?<=\S)\#|[ ]++(?=[^\s\#\0]))*+"""
GAP = re.compile(r"(?:[ ]*+(?:(?<![^ \r\n])#[^\r\n]*+)?+\r?\n)*+[ ]*+")
END = re.compile(r"[ ]*+(?:(?<= )#[^\r\n]*+)?+\r?\n")
"""The end of a line, after what stands in it."""
BLANKS = re.compile(r"[ ]*+\r?\n((?:[ ]*+\r?\n)*+)[ ]*+")
PLAIN = re.compile(rf"(?:{START}|[\-?:](?=[^\s\0])){REST}")
MORE_PLAIN = re.compile(REST)
QUOTED = re.compile(r""""([^"\\]*+(?:\\.[^"\\]*+)*+)"|'([^']*+(?:''[^']*+)*+)'""")
ESCAPE = re.compile(r"\\(?:x([0-9A-Fa-f]{2})|u([0-9A-Fa-f]{4})|(.))")
ESCAPES = {'"': '"', "\\": "\\", "/": "/", "n": "\n", "t": "\t", "r": "\r", " ": " ", "0": "\0"}
FOLD = re.compile(r"[ \t]*+\r?\n((?:[ \t]*+\r?\n)*+)[ \t]*+")
HEADER = re.compile(r"([|>])(-?)[ ]*+(?:(?<= )#[^\r\n]*+)?+\r?\n")
LINE = re.compile(r"([ ]*+)([^\r\n\0]*+)\r?\n")


class Unusual(Exception):
    """No fault: the text wants a parser that knows all of YAML."""


class Scalars:
    """Reads a text piece by piece; every piece comes with the place of what follows it."""

    def __init__(self, text: str) -> None:
        self.text = text + "\n\0"
        self.length = len(text)

    def gap(self, pos: int) -> int:
        """The place of the next thing, past spaces, line ends and comments."""
        return GAP.match(self.text, pos).end()  # type: ignore[union-attr]

    def column(self, pos: int) -> int:
        return pos - self.text.rfind("\n", 0, pos) - 1

    def line_end(self, pos: int) -> int:
        """The place of the next thing, which must stand in a line below."""
        match = END.match(self.text, pos)
        if match is None:
            raise Unusual
        return self.gap(match.end())

    def put(self, parent: Node, node: Node) -> None:
        parent.size += node.size
        if parent.size > MOST_NODES:
            raise too_many(node.start)

    def scalar(self, pos: int, indent: int) -> tuple[Node, int]:
        """A scalar that ends its line; `indent` is the column of the list or mapping it is in."""
        first = self.text[pos]
        if first in "\"'":
            node = self.quoted(pos)
            return node, self.line_end(node.end)
        if first in "|>":
            return self.block_scalar(pos, indent)
        match = PLAIN.match(self.text, pos)
        if match is None:
            raise Unusual
        end, text = match.end(), match[0]
        after = self.line_end(end)
        if after < self.length and self.column(after) > indent:
            text, end = self.folded(text, end, indent, MORE_PLAIN)
            after = self.line_end(end)
            if after < self.length and self.column(after) > indent:
                raise Unusual
        return Node(pos, end, self.value(text), plain=True), after

    def folded(self, text: str, end: int, indent: int, rest: re.Pattern[str]) -> tuple[str, int]:
        """A text without quotes that goes on in lines below."""
        parts = [text]
        while (match := BLANKS.match(self.text, end)) is not None:
            after = match.end()
            if self.text[after] in "#\0" or self.column(after) <= indent:
                break
            more = rest.match(self.text, after)
            if more is None or not more[0]:
                if rest is not MORE_PLAIN and self.text[after] in ",]}":
                    break
                raise Unusual
            parts += ["\n" * match[1].count("\n") or " ", more[0]]
            end = more.end()
        return "".join(parts), end

    def value(self, text: str) -> Any:
        """What a text without quotes means."""
        try:
            return plain_value(text)
        except ScalarFault:
            raise Unusual from None

    def quoted(self, pos: int) -> Node:
        match = QUOTED.match(self.text, pos)
        if match is None:
            raise Unusual
        double, single = match.groups()
        text = double if single is None else single.replace("''", "'")
        if "\n" in text:
            if double is not None and "\\" in text:
                raise Unusual
            text = FOLD.sub(lambda fold: "\n" * fold[1].count("\n") or " ", text)
        elif double is not None and "\\" in text:
            text = ESCAPE.sub(_escaped, text)
        return Node(pos, match.end(), text)

    def block_scalar(self, pos: int, indent: int) -> tuple[Node, int]:
        """`|` or `>` with the lines below it, where none of them is out of line."""
        header = HEADER.match(self.text, pos)
        if header is None or indent < 0:
            raise Unusual
        lines, after = self.lines_below(header.end(), indent)
        content = [line for line in lines if line]
        if header[1] == ">" and any(line[0] in " \t" for line in content):
            raise Unusual
        glue = "\n".join(lines) if header[1] == "|" else _fold(lines)
        node = Node(pos, after, glue if header[2] else glue + "\n")
        after = self.gap(after)
        if after < self.length and self.column(after) > indent:
            raise Unusual
        return node, after

    def lines_below(self, pos: int, indent: int) -> tuple[list[str], int]:
        """The lines of a block scalar without their indentation, and where they end."""
        lines: list[str] = []
        width, whole = 0, 0
        while pos < self.length:
            match = LINE.match(self.text, pos)
            if match is None:
                raise Unusual
            spaces, rest = len(match[1]), match[2]
            if rest:
                width = width or spaces
                if spaces < width:
                    break
                if width <= indent or match.end() > self.length:
                    raise Unusual
                rest = " " * (spaces - width) + rest
                whole = len(lines) + 1
            elif spaces > width:
                raise Unusual
            lines.append(rest)
            pos = match.end()
        if not whole:
            raise Unusual
        return lines[:whole], min(pos, self.length)


def _escaped(match: re.Match[str]) -> str:
    code = match[1] or match[2]
    if code is not None:
        if 0xD800 <= int(code, 16) < 0xE000:
            raise Unusual
        return chr(int(code, 16))
    if match[3] not in ESCAPES:
        raise Unusual
    return ESCAPES[match[3]]


def _fold(lines: list[str]) -> str:
    """Lines as one text: a break becomes a space, empty lines become breaks."""
    text, waiting = "", True
    for line in lines:
        if not line:
            text += "\n"
            waiting = True
        else:
            text += line if waiting else " " + line
            waiting = False
    return text
