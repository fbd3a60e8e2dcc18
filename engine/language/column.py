"""One column of a table: its name, its kind, and how its cells are read.

A header `x (mm)` or `x [mm]` names a column and its unit. A call of `csv` may give the kind of a
column: a unit, or `number`, `integer`, `boolean`, `text`; `x='mm'` also finds a column `x_mm`, as
written in the `data.csv` of a run. Otherwise the kind is inferred from all cells.
"""

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from ...schemas.quantity import UnitError, quantity, unit_of
from ...system.cells import bare
from .types import BOOLEAN, INTEGER, NUMBER, TEXT, Type, number
from .yaml_traps import COMMA

HEADER = re.compile(r"(?P<name>.*?)\s*(?:\((?P<round>[^()]*)\)|\[(?P<square>[^\[\]]*)\])")
KEY = "key"
"""The column of a run's table that names the iteration of each row, as `3,1` in a grid."""
COMMA_ALONE = re.compile(r"[-+]?[0-9]+,[0-9]+(?:[eE][-+]?[0-9]+)?")
BOOLEANS = {"true": True, "false": False}
KINDS = ("text", "number", "integer", "boolean")


class TableFault(ValueError):
    """A table that cannot be read or does not fit; the message says where and why."""


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
    """One column: its name, its kind (a unit, or one of KINDS), and its position."""

    name: str
    kind: str
    place: int
    comma: bool = False
    """Its numbers have a decimal comma, and so no points."""

    @property
    def type(self) -> Type:
        """The type of its values, for the checker."""
        return TYPES[self.kind] if self.kind in TYPES else number(self.kind)

    def plain(self, cell: str) -> Any:
        """The value of a cell without its unit, null for an empty one; raises ValueError."""
        if self.kind == "text":
            return bare(cell)
        if cell == "":
            return None
        return READERS.get(self.kind, _number)(_pointed(cell) if self.comma else cell)

    def read(self, cell: str) -> Any:
        """The value of a cell, null for an empty one; raises ValueError."""
        value = self.plain(cell)
        return value if value is None or self.kind in READERS else quantity(value, self.kind)

    @property
    def wants(self) -> str:
        """What its cells have to be, as messages put it."""
        return WORDS.get(self.kind, f"a number ({self.kind})")


def columns_of(
    file: str,
    header: list[str],
    rows: list[list[str]],
    kinds: Mapping[str, Any],
    *,
    commas: bool = False,
) -> list[Column]:
    """The columns of a table; raises TableFault where header and call do not match.

    With `commas` a number may have a decimal comma: what separates cells is none.
    """
    if header[0] and not any(header[1:]) and any(any(row[1:]) for row in rows):
        raise TableFault(
            f"csv: {file}: the first line names one column, {header[0]!r}, and rows have more; "
            "a title above the names is a comment with # before it"
        )
    heads = ((place, head) for place, head in enumerate(header) if head)
    columns = [_column(file, place, head, rows, kinds, commas) for place, head in heads]
    names = [column.name for column in columns]
    for name in names:
        if names.count(name) > 1:
            raise TableFault(f"csv: {file} has two columns {name!r}")
    for name in kinds:
        if name not in names:
            raise TableFault(f"csv: {file} has no column {name}; it has {', '.join(names)}")
    return columns


def _column(
    file: str,
    place: int,
    head: str,
    rows: list[list[str]],
    kinds: Mapping[str, Any],
    commas: bool,
) -> Column:
    match = HEADER.fullmatch(head)
    name = _word(match["name"] if match else head)
    unit = (match["round"] or match["square"]) if match else None
    if unit is not None and not _is_unit(unit):
        raise TableFault(f"csv: {file}: the column {head!r}: {unit} is not a unit")
    cells = [row[place] for row in rows]
    comma = commas and name != KEY and any(map(COMMA_ALONE.fullmatch, cells))
    for wanted, kind in kinds.items():
        if not isinstance(kind, str) or not (kind in KINDS or _is_unit(kind)):
            raise TableFault(f"csv: {wanted}={kind!r} is neither a unit nor {', '.join(KINDS)}")
        if wanted == name or f"{wanted}_{kind}" == name:
            if unit is not None and unit != kind:
                raise TableFault(f"csv: {file}: the column {head!r} is in {unit}, not in {kind}")
            return Column(wanted, kind, place, comma)
    kind = unit or _inferred([_pointed(cell) for cell in cells] if comma else cells)
    if kind == "text" and name != KEY and not comma and (lone := _decimal_comma(cells)):
        raise TableFault(
            f"csv: {file}: {name} is {lone!r} in a row; numbers have a decimal point, and for "
            f"text say csv({file!r}, {name}='text')"
        )
    return Column(name, kind, place, comma)


def _pointed(cell: str) -> str:
    """A number with a decimal comma as one with a point; a point is then no number's."""
    return cell.replace(".", "_").replace(",", ".", 1)


def _word(head: str) -> str:
    """A header as a name that an expression can use: `Sample no.` is `Sample_no`."""
    return re.sub(r"\W+", "_", head.strip()).strip("_") or "column"


def _is_unit(text: str) -> bool:
    try:
        unit_of(text)
    except UnitError:
        return False
    return True


def _decimal_comma(cells: list[str]) -> str | None:
    """The first number with a decimal comma in a column that holds numbers alone."""
    commas = [cell for cell in cells if COMMA.fullmatch(cell)]
    others = (cell for cell in cells if cell and not COMMA.fullmatch(cell))
    return commas[0] if commas and all(_can_be("number", cell) for cell in others) else None


def _inferred(cells: list[str]) -> str:
    """The kind that fits all cells of a column."""
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
