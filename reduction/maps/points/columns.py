"""Read a CSV table as columns of text, and say in a sentence why one cannot be read."""

import csv
import math
from dataclasses import dataclass
from io import StringIO
from pathlib import Path

import numpy as np

from ....system.cells import bare
from ...spectrum.fault import Unreadable
from ...spectrum.spectrum import FloatArray

NO_NUMBER = ("", "nan", "na", "null", "none")
DELIMITERS = ",;\t"
SHOWN = 40  # characters of a cell that a sentence repeats


@dataclass(frozen=True, slots=True)
class Columns:
    """The cells of a table, stripped; every column has `n` of them."""

    path: Path
    cells: dict[str, list[str]]
    n: int

    def __contains__(self, name: str) -> bool:
        return name in self.cells

    def text(self, name: str) -> list[str]:
        """A column's cells; empty ones where the table has no such column."""
        return self.cells.get(name, [""] * self.n)

    def numbers(self, name: str) -> FloatArray:
        """A column as numbers, shape (n,): NaN for an empty cell and for text."""
        return np.array([number(cell) for cell in self.text(name)], dtype=np.float64)

    def odd(self, name: str) -> list[str]:
        """The cells that should be numbers, and are text."""
        return [
            cell[:SHOWN]
            for cell in self.text(name)
            if cell.lower() not in NO_NUMBER and not math.isfinite(number(cell))
        ]


def number(cell: str) -> float:
    """A cell as a number; NaN where it is none, or infinite."""
    try:
        value = float(cell)
    except ValueError:
        return math.nan
    return value if math.isfinite(value) else math.nan


def read_columns(path: Path) -> Columns:
    """The table in a CSV file; short rows end in empty cells.

    Commas, semicolons or tabs between the columns, as the header has them. Raises Unreadable for
    what is no table, with the file's name; OSError is told in the same way.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError:
        raise Unreadable(f"{path} is not UTF-8 text, so it is not a table") from None
    except OSError as fault:
        raise Unreadable(f"{path} cannot be read: {fault.strerror}") from None
    header = text.partition("\n")[0]
    delimiter = max(DELIMITERS, key=header.count)
    try:
        rows = [row for row in csv.reader(StringIO(text, newline=""), delimiter=delimiter) if row]
    except csv.Error as fault:
        raise Unreadable(f"{path} is no table: {fault}") from None
    if not rows:
        raise Unreadable(f"{path} is empty: it has no header and no row")
    names = [name.strip() for name in rows[0]]
    twice = sorted({name for name in names if name and names.count(name) > 1})
    if twice:
        raise Unreadable(f"{path} has two columns of the name {twice[0]!r}")
    body = rows[1:]
    cells = {
        name: [bare(row[at].strip()) if at < len(row) else "" for row in body]
        for at, name in enumerate(names)
        if name
    }
    return Columns(path, cells, len(body))
