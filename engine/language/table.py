"""A CSV file as rows with typed columns: what `csv('samples.csv', x='mm')` gives."""

import csv
import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from .column import Column, TableFault, columns_of
from .grid import Lazy
from .types import Type
from .used_files import FileFault, find_file
from .yaml_traps import COMMA

LARGEST = 50_000_000
"""Bytes; a million rows of a few numbers."""


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
    _cells: dict[str, list[list[str]]] = field(default_factory=dict)
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


def _table(file: str, cells: Sequence[list[str]], kinds: Mapping[str, Any]) -> Table:
    header, *rows = cells
    _level(file, len(header), rows)
    columns = columns_of(file, header, rows, kinds)
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
        raise TableFault(f"csv: {file} is not UTF-8 text; save it with that encoding") from fault


def _rows(file: str, text: str) -> list[list[str]]:
    first = text.partition("\n")[0]
    delimiter = max(",;\t", key=first.count) if any(c in first for c in ",;\t") else ","
    try:
        rows = [[cell.strip() for cell in row] for row in _reader(text, delimiter)]
    except csv.Error as fault:
        raise TableFault(f"csv: {file} is not a table: {fault}") from fault
    rows = [row for row in rows if any(row) and not row[0].startswith("#")]
    if not rows:
        raise TableFault(f"csv: {file} is empty; its first line names the columns")
    return rows


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
                point = "; numbers have a decimal point" if COMMA.fullmatch(cell) else ""
                raise TableFault(
                    f"csv: {file}, row {index}: {column.name} is {cell!r}, "
                    f"which is not {column.wants}{point}"
                ) from None
