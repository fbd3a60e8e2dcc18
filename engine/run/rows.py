"""The rows that a loop collects: one line of a CSV file for each iteration, units in the header."""

import csv
import io
from collections import deque
from collections.abc import Iterable, Mapping
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from ...schemas.journal import IterationEnded, JournalRecord
from ...schemas.quantity import is_quantity, magnitude_in, number_text
from ...system import WINDOWS
from ...system.cells import guarded
from ...system.files import remove
from ..journal.encode import decode
from ..journal.history import superseded
from ..journal.journal import Records
from ..language.column import KEY
from ..language.expression import ExpressionError
from ..language.moments import moment_text
from ..language.value import Value
from .files import NoRoom

UNITS = {
    "mm", "um", "nm", "m", "s", "ms", "min", "h", "mg", "g", "kg", "ul", "ml", "l", "K", "degC",
    "bar", "mbar", "Pa", "kPa", "V", "mV", "A", "mA", "W", "J", "Hz", "kHz", "percent",
    "mm/min", "mm/s", "count",
}  # fmt: skip
"""Those that are found again in a column's name; others are taken as part of it."""


class Rows:
    """A table that grows by one row per iteration; it can be recreated from the journal."""

    def __init__(self, path: Path, columns: Mapping[str, Value | None]) -> None:
        self.path = path
        self.columns = columns
        self.units: dict[str, str] = {}
        self._begun = False
        self._held: dict[str, dict[int, tuple[str, Mapping[str, Any], str]]] = {}
        """By loop and index: rows of iterations that are over before others before them."""
        self._waiting: deque[tuple[str, Mapping[str, Any], str]] = deque()

    def evaluate(self, names: Mapping[str, Any]) -> dict[str, Any]:
        """A row's values; null if a step that it needs did not run or gave no such value."""
        row: dict[str, Any] = {}
        for name, value in self.columns.items():
            try:
                found = value.evaluate(names) if value is not None else None
                row[name] = moment_text(found) if isinstance(found, datetime) else found
            except ExpressionError:
                row[name] = None
        return row

    def write(self, key: str, row: Mapping[str, Any], fate: str) -> str:
        """Append a row; the first one creates the file. Raises NoRoom.

        On Windows nobody may write what a spreadsheet program shows: rows wait until it is closed, and
        what is returned the first time says so.
        """
        self._waiting.append((key, row, fate))
        try:
            if self._write_what_waits() or len(self._waiting) > 1:
                return ""
        except OSError as fault:
            raise NoRoom(f"cannot write {self.path}: {fault.strerror}") from fault
        return (
            f"{self.path.name} is open in another program; its rows wait until it is closed there"
        )

    def hold(self, loop: str, index: int, key: str, row: Mapping[str, Any], fate: str) -> None:
        """Keep a row until those before it are written."""
        self._held.setdefault(loop, {})[index] = key, row, fate

    def release(self, loop: str, before: int | None = None) -> str:
        """Write the rows that were held, those before an index or all, in order; as `write`."""
        held, told = self._held.get(loop, {}), ""
        for index in sorted(held):
            if before is None or index < before:
                told = self.write(*held.pop(index)) or told
        return told

    def finish(self) -> str:
        """Write what still waits, beside the table where it must be; what to tell, if anything."""
        try:
            for loop in list(self._held):
                self.release(loop)
            if self._write_what_waits():
                return ""
            beside = self.path.with_stem(f"{self.path.stem}-rest")
            count, table = len(self._waiting), Rows(beside, self.columns)
            while self._waiting:
                table.write(*self._waiting.popleft())
            name = self.path.name
            return f"{name} is still open in another program: its last {count} rows are in {beside.name}"
        except (OSError, NoRoom) as fault:
            return f"rows of {self.path.name} are in the journal only: {fault}"

    def _write_what_waits(self) -> bool:
        while self._waiting:
            try:
                self._write(*self._waiting[0])
            except PermissionError:
                if not WINDOWS:
                    raise
                return False
            self._waiting.popleft()
        return True

    def begin(self) -> None:
        """Create the file, with its header, if it is not there yet."""
        if not self._begun:
            self._write_header(self.units)

    def _write(self, key: str, row: Mapping[str, Any], fate: str) -> None:
        new_units = {
            name: f"{value.units:~}"
            for name, value in row.items()
            if is_quantity(value) and name not in self.units
        }
        if not self._begun or new_units:
            self._write_header({**self.units, **new_units})
        cells = [guarded(key), *(self._cell(name, row.get(name)) for name in self.columns), fate]
        with self.path.open("a", encoding="utf-8", newline="") as file:
            file.write(_csv_line(cells))

    def _write_header(self, units: dict[str, str]) -> None:
        names = [name + suffix(units.get(name)) for name in self.columns]
        header = _csv_line([KEY, *names, "fate"])
        rows = ""
        if self._begun:  # a unit that the first rows, with nulls, did not show yet
            rows = self.path.read_text(encoding="utf-8").partition("\n")[2]
        self.path.write_text(header + rows, encoding="utf-8", newline="")
        self._begun, self.units = True, units

    def _cell(self, name: str, value: Any) -> str:
        if value is None:
            return ""
        if is_quantity(value):
            value = magnitude_in(value, self.units[name])
        if isinstance(value, float):
            return number_text(value)
        return guarded(value) if isinstance(value, str) else str(value)


def suffix(unit: str | None) -> str:
    """What a column's name ends with in the table: `_mm`; nothing without a unit."""
    if not unit:
        return ""
    plain = unit.replace(" ", "").replace("**", "").replace("µ", "u").replace("L", "l")
    return "_" + plain.replace("/", "_per_")


def unit_in(column: str) -> str:
    """The unit that a column's name ends with (`x_mm`, `feed_mm_per_min`); empty for none."""
    _, mark, rest = column.partition("_")
    while mark:
        if (unit := rest.replace("_per_", "/")) in UNITS:
            return unit[:-1] + "L" if unit in ("ul", "ml", "l") else unit
        _, mark, rest = rest.partition("_")
    return ""


def _csv_line(cells: list[str]) -> str:
    line = io.StringIO()
    csv.writer(line, lineterminator="\n").writerow(cells)
    return line.getvalue()


def restore_rows(
    folder: Path, records: Iterable[JournalRecord], tables: Mapping[str, Rows]
) -> None:
    """Write the tables of a run again from its journal: this repairs a row torn by a crash.

    A table of which every row is to be measured again has only its header until then.
    """
    for name in tables:
        with suppress(PermissionError):  # shown by another program, on Windows: its rows wait
            remove(folder / name)
    is_superseded = superseded(records)
    if isinstance(records, Records):
        records = records.of("iteration")
    for record in records:
        if not isinstance(record, IterationEnded) or record.row is None:
            continue
        if record.file in tables and is_superseded(record):
            tables[record.file].begin()
        elif record.file in tables:
            table, row = tables[record.file], decode(record.row)
            if record.ahead:
                table.hold(record.loop, record.index, record.row_key, row, record.fate)
            else:
                table.release(record.loop, record.index)
                table.write(record.row_key, row, record.fate)
