"""Work out the column of each line of YAML text from the tokens of ruamel.yaml's scanner."""

from bisect import bisect_left
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Literal

STEP = 2
"""Spaces per level."""
MARKERS = {"DocumentStartToken", "DocumentEndToken", "DirectiveToken"}
OPENS: "dict[str, Literal['mapping', 'list']]" = {
    "BlockMappingStartToken": "mapping", "BlockSequenceStartToken": "list",
}  # fmt: skip
FLOW_STARTS = {"FlowSequenceStartToken", "FlowMappingStartToken"}
FLOW_ENDS = {"FlowSequenceEndToken", "FlowMappingEndToken"}
STREAM = {"StreamStartToken", "StreamEndToken"}


@dataclass(frozen=True, slots=True)
class Block:
    """A mapping or list over several lines: the column in which it begins, before and after.

    A `level` list is in the column of its key: no token marks where it begins and ends.
    """

    kind: Literal["mapping", "list", "level"]
    old: int
    new: int


def even_lines(text: str) -> Iterator[str]:
    """The lines of a text, each in its column, without blank lines at the end."""
    lines = text.split("\n")
    layout = Layout(lines)
    layout.read(text)
    last = max((n for n, line in enumerate(lines) if line.strip() or n in layout.kept), default=0)
    for number, line in enumerate(lines[: last + 1]):
        yield layout.moved(number, line)


class Layout:
    """The column for the first word of each line."""

    def __init__(self, lines: list[str]) -> None:
        self.lines = lines
        self.column: dict[int, int] = {}
        self.kept: set[int] = set()
        """Lines within a text value, whose trailing blanks may matter."""
        self.gaps: dict[int, list[tuple[int, int]]] = {}
        """Blanks after dashes, of which one remains."""
        self.around: dict[int, list[Block]] = {}
        """The blocks that are open after the last word of a line."""
        self.stack: list[Block] = []
        self.shift = 0
        self.brackets = 0
        self.opened = 0

    def read(self, text: str) -> None:
        """Read the whole text."""
        from ruamel.yaml import YAML

        for token in YAML(typ="safe", pure=True).scan(text):
            kind = type(token).__name__
            if kind == "BlockEndToken":
                self.close()
            elif self.brackets:
                self.within_brackets(kind, token)
            elif kind not in STREAM:
                self.take(kind, token, token.start_mark.line, token.start_mark.column)
        self.comments()

    def moved(self, number: int, line: str) -> str:
        """A line moved to its column, if it has one."""
        for start, length in reversed(self.gaps.get(number, [])):
            line = f"{line[:start]} {line[start + length :]}"
        words = line.lstrip(" ")
        if number not in self.kept:
            words = words.rstrip(" \t")
            if not words:
                return ""
        return " " * self.column.get(number, len(line) - len(words)) + words

    # --- block structure

    def take(self, kind: str, token: Any, line: int, column: int) -> None:
        """Process one token that is not between brackets."""
        first = line not in self.column and not self.lines[line][:column].strip()
        if kind in OPENS:
            new = self.below() if first else column + self.shift
            self.stack.append(Block(OPENS[kind], column, new))
            return
        self.level_list(kind, column)
        if first:
            self.column[line] = self.goes_to(kind)
            self.shift = self.column[line] - column
        self.around[line] = list(self.stack)
        if kind == "BlockEntryToken":
            self.dash(line, column)
        elif kind in FLOW_STARTS:
            self.brackets, self.opened = 1, line
        elif kind == "ScalarToken":
            self.text(token, line)

    def level_list(self, kind: str, column: int) -> None:
        """Begin or end a list that is in the column of its key."""
        top = self.stack[-1] if self.stack else None
        if top is None:
            return
        if kind == "KeyToken" and top.kind == "level":
            self.stack.pop()
        elif kind == "BlockEntryToken" and top.kind == "mapping" and top.old == column:
            self.stack.append(Block("level", column, top.new + STEP))

    def close(self) -> None:
        if self.stack[-1].kind == "level":
            self.stack.pop()
        self.stack.pop()

    def below(self) -> int:
        return self.stack[-1].new + STEP if self.stack else 0

    def goes_to(self, kind: str) -> int:
        """The column of a line that begins with this token."""
        if kind in MARKERS or not self.stack:
            return 0
        own = kind in ("KeyToken", "ValueToken", "BlockEntryToken")
        return self.stack[-1].new if own else self.below()

    def dash(self, line: int, column: int) -> None:
        """Keep one blank after a dash, if words follow it."""
        rest = self.lines[line][column + 1 :]
        blanks = len(rest) - len(rest.lstrip(" "))
        if rest.strip() and not rest.lstrip().startswith("#"):
            self.gaps.setdefault(line, []).append((column + 1, blanks))
            self.shift -= blanks - 1

    # --- what continues over several lines moves with its first line

    def text(self, token: Any, line: int) -> None:
        """The lines of a text value below its first."""
        last = token.end_mark.line if token.end_mark.column else token.end_mark.line - 1
        least, shift = self.below() - STEP + 1 if self.stack else 0, self.shift
        if token.style in ("|", ">"):
            # Its own indentation is relative to that of the block that contains it.
            least, shift = 0, self.stack[-1].new - self.stack[-1].old if self.stack else 0
        self.go_along(range(line + 1, last + 1), shift, least)
        self.kept.update(range(line + 1, last + 1))

    def within_brackets(self, kind: str, token: Any) -> None:
        """Lines within brackets: YAML ignores their indentation."""
        start, end = token.start_mark.line, token.end_mark.line
        if kind == "ScalarToken":
            self.kept.update(range(start + 1, end + 1))
        self.brackets += (kind in FLOW_STARTS) - (kind in FLOW_ENDS)
        if not self.brackets:
            self.go_along(range(self.opened + 1, end + 1), self.shift, 0)

    def go_along(self, numbers: range, shift: int, least: int) -> None:
        for number in numbers:
            line = self.lines[number]
            if line:
                self.column[number] = max(least, len(line) - len(line.lstrip(" ")) + shift)

    # --- comments

    def comments(self) -> None:
        """Move a comment with the line below it, or with the block above that it is aligned with."""
        numbers = [n for n, line in enumerate(self.lines) if line.strip()]
        placed = [n for n in numbers if n in self.column]
        known = [n for n in placed if n in self.around]
        for number in [n for n in numbers if n not in self.column]:
            below, above = bisect_left(placed, number), bisect_left(known, number)
            self.column[number] = self.of_comment(
                number,
                known[above - 1] if above else None,
                placed[below] if below < len(placed) else None,
            )

    def of_comment(self, number: int, above: int | None, below: int | None) -> int:
        column = _indent(self.lines[number])
        if below is not None and column == _indent(self.lines[below]):
            return self.column[below]
        blocks = [
            *(self.around.get(below, []) if below is not None else []),
            *(self.around[above] if above is not None else []),
        ]
        outer = [block for block in blocks if block.old <= column]
        if not outer:
            return column
        near = max(outer, key=lambda block: block.old)
        return column + near.new - near.old


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip(" "))
