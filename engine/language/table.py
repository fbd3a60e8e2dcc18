"""A CSV file as rows with typed columns: what `csv('samples.csv', x='mm')` gives.

A header `x (mm)` or `x [mm]` names a column and its unit. A call may say the kind of a column: a
unit, or `number`, `integer`, `boolean`, `text`; `x='mm'` also finds a column `x_mm`, as `data.csv`
of a run writes it. What nothing is said of is what all its cells can be.
"""

import csv
import io
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...schemas.quantity import UnitError, quantity, unit_of
from .grid import Lazy
from .types import BOOLEAN, INTEGER, NUMBER, TEXT, Type, number
from .used_files import FileFault, find_file

LARGEST = 50_000_000
"""Bytes; a million rows of a few numbers."""
HEADER = re.compile(r"(?P<name>.*?)\s*(?:\((?P<round>[^()]*)\)|\[(?P<square>[^\[\]]*)\])")
BOOLEANS = {"true": True, "false": False}
KINDS = ("text", "number", "integer", "boolean")


class TableFault(ValueError):
    """A table that cannot be read or does not fit; the text says where and why."""


def _integer(text: str) -> int:
    if not re.fullmatch(r"[+-]?\d{1,300}", text):
        raise ValueError(text)
    return int(text)


def _number(text: str) -> float | int:
    try:
        return _integer(text)
    except ValueError:
        value = float(text)
    if value != value or value in (float("inf"), float("-inf")) or "_" in text:
        raise ValueError(text)
    return value


def _boolean(text: str) -> bool:
    try:
        return BOOLEANS[text.casefold()]
    except KeyError:
        raise ValueError(text) from None


READERS: dict[str, Callable[[str], Any]] = {
    "integer": _integer, "number": _number, "boolean": _boolean, "text": str,
}  # fmt: skip
TYPES = {"integer": INTEGER, "number": NUMBER, "boolean": BOOLEAN, "text": TEXT}
WORDS = {"integer": "a whole number", "number": "a number", "boolean": "true or false"}


@dataclass(frozen=True, slots=True)
class Column:
    """One column: its name, its kind (a unit, or one of KINDS), and where it stands."""

    name: str
    kind: str
    place: int

    @property
    def type(self) -> Type:
        """What the checker knows of its values."""
        return TYPES[self.kind] if self.kind in TYPES else number(self.kind)

    def read(self, cell: str) -> Any:
        """The value of a cell, null of an empty one; raises ValueError."""
        if cell == "":
            return "" if self.kind == "text" else None
        if self.kind in READERS:
            return READERS[self.kind](cell)
        return quantity(_number(cell), self.kind)


class Table(Lazy):
    """The rows of a file, each a set of fields, made when they are asked for."""

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
    """The function `csv` of one protocol: reads each file once, beside the protocol's own."""

    protocol: Path
    opened: dict[str, Path] = field(default_factory=dict)
    _cells: dict[str, list[list[str]]] = field(default_factory=dict)
    _made: dict[tuple[Any, ...], Table] = field(default_factory=dict)

    def __call__(self, file: Any = None, **kinds: Any) -> Table:
        """The table of a file; raises TableFault."""
        if not isinstance(file, str):
            raise TableFault("csv: the name of a file is wanted: csv('samples.csv')")
        call = (file, *sorted((name, str(kind)) for name, kind in kinds.items()))
        if call not in self._made:
            self._made[call] = self._make(file, kinds)
        return self._made[call]

    def _make(self, file: str, kinds: Mapping[str, Any]) -> Table:
        if file not in self._cells:
            path, text = _text(self.protocol, file)
            self._cells[file] = _rows(file, text)
            self.opened[file] = path
        header, *rows = self._cells[file]
        columns = _columns(file, header, rows, kinds)
        _check(file, columns, rows)
        return Table(columns, rows)


def _text(protocol: Path, file: str) -> tuple[Path, str]:
    try:
        path, data = find_file(protocol, file, LARGEST)
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


def _columns(
    file: str, header: list[str], rows: list[list[str]], kinds: Mapping[str, Any]
) -> list[Column]:
    columns = [_column(file, place, head, rows, kinds) for place, head in enumerate(header) if head]
    names = [column.name for column in columns]
    for name in names:
        if names.count(name) > 1:
            raise TableFault(f"csv: {file} has two columns {name!r}")
    for name in kinds:
        if name not in names:
            raise TableFault(f"csv: {file} has no column {name}; it has {', '.join(names)}")
    return columns


def _column(
    file: str, place: int, head: str, rows: list[list[str]], kinds: Mapping[str, Any]
) -> Column:
    match = HEADER.fullmatch(head)
    name = _word(match["name"] if match else head)
    unit = (match["round"] or match["square"]) if match else None
    if unit is not None and not _is_unit(unit):
        raise TableFault(f"csv: {file}: the column {head!r}: {unit} is not a unit")
    for wanted, kind in kinds.items():
        if not isinstance(kind, str) or not (kind in KINDS or _is_unit(kind)):
            raise TableFault(f"csv: {wanted}={kind!r} is neither a unit nor {', '.join(KINDS)}")
        if wanted == name or f"{wanted}_{kind}" == name:
            if unit is not None and unit != kind:
                raise TableFault(f"csv: {file}: the column {head!r} is in {unit}, not in {kind}")
            return Column(wanted, kind, place)
    return Column(name, unit or _inferred([row[place] for row in rows if place < len(row)]), place)


def _word(head: str) -> str:
    """A header as a name that an expression can use: `Sample no.` is `Sample_no`."""
    return re.sub(r"\W+", "_", head.strip()).strip("_") or "column"


def _is_unit(text: str) -> bool:
    try:
        unit_of(text)
    except UnitError:
        return False
    return True


def _inferred(cells: list[str]) -> str:
    """What all cells of a column can be."""
    filled = [cell for cell in cells if cell]
    for kind in ("integer", "number", "boolean"):
        if filled and all(_can_be(kind, cell) for cell in filled):
            return kind
    return "text"


def _can_be(kind: str, cell: str) -> bool:
    try:
        READERS[kind](cell)
    except ValueError:
        return False
    return True


def _check(file: str, columns: Sequence[Column], rows: list[list[str]]) -> None:
    """Every cell is what its column says: a fault is found before the run, not at its row."""
    width = max((column.place for column in columns), default=-1) + 1
    for number_, row in enumerate(rows, 1):
        row += [""] * (width - len(row))
        for column in columns:
            try:
                if row[column.place]:
                    READERS.get(column.kind, _number)(row[column.place])
            except ValueError:
                wanted = WORDS.get(column.kind, f"a number ({column.kind})")
                raise TableFault(
                    f"csv: {file}, row {number_}: {column.name} is "
                    f"{row[column.place]!r}, which is not {wanted}"
                ) from None
