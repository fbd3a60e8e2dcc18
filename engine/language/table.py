"""A CSV file as rows with typed columns: what `csv('samples.csv', x='mm')` gives."""

import csv
import io
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .column import Column, TableFault, columns_of
from .grid import Lazy
from .types import Type
from .used_files import FileFault, find_file
from .yaml_traps import point_for

LARGEST = 50_000_000
"""Bytes; a million rows of a few numbers."""
EXCEL = "in Excel: CSV UTF-8"
SEPARATOR = re.compile(r"sep=([,;\t])\r?\n")


class Table(Lazy):
    """The rows of a file, each a set of fields, made on demand."""

    def __init__(self, columns: Sequence[Column], cells: Sequence[Sequence[str]]) -> None:
        self.columns, self.cells = columns, cells

    def __len__(self) -> int:
        return len(self.cells)

    def item(self, index: int) -> dict[str, Any]:
        row = self.cells[index]
        return {column.name: column.read(row[column.place]) for column in self.columns}

    @property
    def type(self) -> Type:
        """A list of rows with these fields."""
        fields = {column.name: column.type for column in self.columns}
        return Type("list", item=Type("map", fields=fields))


@dataclass(slots=True, eq=False)
class Tables:
    """The function `csv` of one protocol: reads each file once, from `folders` or below."""

    protocol: Path
    folders: Sequence[Path]
    opened: dict[str, Path] = field(default_factory=dict)
    _cells: dict[str, "Cells"] = field(default_factory=dict)
    _made: dict[tuple[Any, ...], Table] = field(default_factory=dict)

    def __call__(self, file: Any = None, **kinds: Any) -> Table:
        """The table of a file; raises TableFault."""
        if not isinstance(file, str):
            raise TableFault("csv needs the name of a file: csv('samples.csv')")
        call = (file, *sorted((name, str(kind)) for name, kind in kinds.items()))
        if call not in self._made:
            self._made[call] = self._make(file, kinds)
        return self._made[call]

    def _make(self, file: str, kinds: Mapping[str, Any]) -> Table:
        if file not in self._cells:
            path, text = _text(self.protocol, file, self.folders)
            self._cells[file] = _rows(file, text)
            self.opened[file] = path
        return _table(file, self._cells[file], kinds)


def table_of(file: str, text: str) -> Table:
    """The table that a file of this text is; raises TableFault."""
    return _table(file, _rows(file, text), {})


Cells = tuple[str, list[list[str]]]
"""What separates the cells, and they themselves."""


def _table(file: str, cells: Cells, kinds: Mapping[str, Any]) -> Table:
    delimiter, (header, *rows) = cells
    _level(file, len(header), rows)
    columns = columns_of(file, header, rows, kinds, commas=delimiter == ";")
    _check(file, columns, rows)
    return Table(columns, rows)


def _level(file: str, width: int, rows: list[list[str]]) -> None:
    """Fill rows that end early: Excel leaves out empty cells there. One too many shifts the others."""
    for index, row in enumerate(rows, 1):
        if any(row[width:]):
            raise TableFault(
                f"csv: {file}, row {index} has {len(row)} cells, and the first line names {width}; "
                "text with a comma needs quotes, and a number a decimal point"
            )
        row += [""] * (width - len(row))


def _text(protocol: Path, file: str, folders: Sequence[Path]) -> tuple[Path, str]:
    try:
        path, data = find_file(protocol, file, LARGEST, folders)
    except FileFault as fault:
        raise TableFault(f"csv: {fault}") from fault
    try:
        return path, data.decode("utf-8-sig")
    except UnicodeDecodeError as fault:
        raise TableFault(
            f"csv: {file} is not UTF-8 text; save it with that encoding ({EXCEL})"
        ) from fault


def _rows(file: str, text: str) -> Cells:
    if "\0" in text:
        raise TableFault(
            f"csv: {file} is not text; a workbook has to be saved as a table ({EXCEL})"
        )
    if said := SEPARATOR.match(text):  # Excel's own first line
        text = text[said.end() :]
    first = text.partition("\n")[0]
    delimiter = max(",;\t", key=first.count) if any(c in first for c in ",;\t") else ","
    delimiter = said[1] if said else delimiter
    try:
        rows = [[cell.strip() for cell in row] for row in _reader(text, delimiter)]
    except csv.Error as fault:
        raise TableFault(f"csv: {file} is not a table: {fault}") from fault
    rows = [row for row in rows if any(row) and not row[0].startswith("#")]
    if not rows:
        raise TableFault(f"csv: {file} is empty; its first line names the columns")
    return delimiter, rows


def _reader(text: str, delimiter: str) -> Any:
    return csv.reader(io.StringIO(text, newline=""), delimiter=delimiter, strict=True)


def _check(file: str, columns: Sequence[Column], rows: list[list[str]]) -> None:
    """Check every cell against its column, so that faults are found before the run."""
    for index, row in enumerate(rows, 1):
        for column in columns:
            cell = row[column.place]
            try:
                column.plain(cell)
            except ValueError:
                point = f"; {hint}" if (hint := point_for(cell)) else ""
                if column.comma:
                    point = "; where one number of a column has a decimal comma, none has a point"
                raise TableFault(
                    f"csv: {file}, row {index}: {column.name} is {cell!r}, "
                    f"which is not {column.wants}{point}"
                ) from None
