"""Tables of a run, such as `data.csv`, read again only when they grow."""

import csv
import io
import math
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ...engine.run.rows import unit_in
from ...system.cells import bare
from ..local.refusal import not_found
from ..models.results import Column, TableHead, TableWindow

PATTERN = "data*.csv"
BESIDE = ("key", "fate")
"""Columns that the engine adds to those of the protocol."""


@dataclass(frozen=True)
class Table:
    """One table: its columns of text, all of one length."""

    name: str
    columns: dict[str, list[str]]

    @property
    def rows(self) -> int:
        """Number of rows."""
        return len(next(iter(self.columns.values()), []))

    @cached_property
    def numbers(self) -> dict[str, list[float | None]]:
        """The columns that hold only numbers and empty cells."""
        found = {}
        for name, cells in self.columns.items():
            if name not in BESIDE:
                read = [_number(cell) for cell in cells]
                if not any(value is _NONE for value in read) and any(v is not None for v in read):
                    found[name] = read
        return found

    def head(self) -> TableHead:
        """As sent to the page."""
        columns = [
            Column(name=name, unit=unit_in(name) or None, numeric=name in self.numbers)
            for name in self.columns
        ]
        return TableHead(name=self.name, columns=columns, rows=self.rows)

    def window(self, offset: int, limit: int) -> TableWindow:
        """Some rows, numbers as numbers."""
        part = slice(offset, offset + limit)
        columns: dict[str, list[Any]] = {
            name: self.numbers[name][part] if name in self.numbers
            else [cell or None for cell in cells[part]]
            for name, cells in self.columns.items()
        }  # fmt: skip
        return TableWindow(name=self.name, offset=offset, total=self.rows, columns=columns)

    def parquet(self) -> bytes:
        """The table in Apache Parquet."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        made = {
            name: pa.array(self.numbers[name], pa.float64()) if name in self.numbers
            else pa.array([cell or None for cell in cells], pa.string())
            for name, cells in self.columns.items()
        }  # fmt: skip
        out = io.BytesIO()
        pq.write_table(pa.table(made), out)
        return out.getvalue()


_NONE: Any = object()


def _number(cell: str) -> float | None:
    if not cell:
        return None
    try:
        value = float(cell)
    except ValueError:
        return _NONE
    return value if math.isfinite(value) else None


def table_names(folder: Path) -> list[str]:
    """The tables of a run, `data.csv` first."""
    files = sorted(folder.glob(PATTERN), key=lambda path: path.stem)
    return [path.name for path in files if path.is_file()]


def read_table(folder: Path, name: str) -> Table:
    """One table; raises Refusal (404). A row still being written is left out."""
    if name not in table_names(folder):
        raise not_found("table", name, "a run has one for each loop that collects rows")
    return Table(name, read_rows(folder / name))


def read_rows(path: Path) -> dict[str, list[str]]:
    """The columns of a CSV file, all of one length."""
    text = path.read_text(encoding="utf-8-sig")
    whole = text[: text.rfind("\n") + 1]
    rows = list(csv.reader(io.StringIO(whole)))
    if not rows:
        return {}
    header, *body = rows
    columns: dict[str, list[str]] = {column: [] for column in header}
    for row in body:
        for index, column in enumerate(header):
            columns[column].append(bare(row[index]) if index < len(row) else "")
    return columns
