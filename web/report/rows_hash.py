"""A hash of the journal's rows, so that a table on disk can be checked against it."""

import csv
from dataclasses import dataclass, field
from hashlib import blake2b
from pathlib import Path
from typing import Any

from ...engine.journal.encode import QUANTITY_KEY, decode
from ...schemas.journal import IterationEnded
from ...schemas.quantity import magnitude_in, number_text
from ...system.cells import bare

SEPARATOR = "\x1f"
NESTED = ("(", "[", "{")
"""Lists and mappings cannot be compared: the table has them as Python wrote them."""


@dataclass(slots=True)
class RowsHash:
    """How many rows a table must have, and a hash over their cells."""

    count: int = 0
    units: dict[str, str] = field(default_factory=dict)
    _hash: Any = field(default_factory=lambda: blake2b(digest_size=16))

    def add(self, record: IterationEnded) -> None:
        """Add one row, as the engine writes it."""
        cells = [self._cell(name, told) for name, told in (record.row or {}).items()]
        self.count += 1
        self._hash.update(_line([record.row_key, *cells, record.fate]))

    def _cell(self, name: str, told: Any) -> str:
        if told is None:
            return ""
        if isinstance(told, dict) and QUANTITY_KEY in told:
            magnitude, unit = told[QUANTITY_KEY]
            wanted = self.units.setdefault(name, unit)
            told = magnitude if unit == wanted else magnitude_in(decode(told), wanted)
        return number_text(told) if isinstance(told, float) else str(told)

    def fits(self, path: Path) -> bool:
        """True if the table on disk holds exactly these rows, in this order."""
        found = blake2b(digest_size=16)
        lines = 0
        try:
            with path.open(encoding="utf-8", newline="") as file:
                rows = csv.reader(file)
                next(rows, None)
                for row in rows:
                    lines += 1
                    found.update(_line([bare(cell) for cell in row]))
        except (OSError, UnicodeError, csv.Error):
            return False
        return lines == self.count and found.digest() == self._hash.digest()


def _line(cells: list[str]) -> bytes:
    told = ("" if cell.startswith(NESTED) else cell for cell in cells)
    return f"{SEPARATOR.join(told)}\n".encode(errors="surrogateescape")
