"""Convert offsets in a text to lines and columns, both from 1, lines as editors count them."""

import re
from bisect import bisect_right

BREAK = re.compile(r"\r\n?|\n")


class Lines:
    """Where the lines of a text begin."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.starts = [0, *(match.end() for match in BREAK.finditer(text))]

    def place(self, offset: int) -> tuple[int, int]:
        """Line and column of an offset."""
        line = bisect_right(self.starts, offset)
        return line, offset - self.starts[line - 1] + 1

    def line(self, number: int) -> str:
        """The text of a line, without its end."""
        end = self.starts[number] if number < len(self.starts) else len(self.text)
        return self.text[self.starts[number - 1] : end].rstrip("\r\n")

    def span(self, start: int, end: int) -> tuple[int, int, int]:
        """Line, column and length of the text between two offsets, on its first line."""
        line, column = self.place(start)
        rest = len(self.line(line).rstrip()) - column + 1
        length = end - start if self.place(max(start, end - 1))[0] == line else rest
        return line, column, max(1, min(length, rest))
